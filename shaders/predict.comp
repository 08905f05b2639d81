// Stage predict: one invocation per vertex.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/predict.glsl"

void main() {
  uint i = item_index();
  if (i >= push.substep.vertex_count) return;
  if (with_implicit)
    begin_implicit(i);
  else if (!is_kinematic(i)) velocity[i] = record_of(predicted_velocity(i));
}
