// Stage collide within the implicit integrator's iterations: each ends outside the solids. One invocation per vertex.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/collide.glsl"

void main() {
  uint i = item_index();
  if (i >= push.substep.vertex_count) return;
  if (is_kinematic(i)) return;
  Collided c = collided(i, vector_of(position_before[i]), vector_of(position[i]), zero_vector());
  if (c.touches) position[i] = record_of(c.place);
}
