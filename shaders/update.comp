// Stages predict, goal and integrate in one dispatch, for runs without a probe: the same kernels, the same bits.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/goal.glsl"
#include "shaders/indexing/integrate.glsl"
#include "shaders/indexing/predict.glsl"

void main() {
  uint i = item_index();
  if (i >= push.substep.vertex_count) return;
  if (is_kinematic(i))
    move_kinematic(i);
  else
    move_free(i, predicted_velocity(i), blended_goal(i));
}
