// Stages goal and relax in one dispatch, for runs without a probe: the same kernels, the same bits.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/goal.glsl"
#include "shaders/indexing/relax.glsl"

void main() {
  uint i = item_index();
  if (i >= push.substep.vertex_count) return;
  if (is_kinematic(i)) return;
  Vector g = blended_goal(i);
  goal[i] = record_of(g);
  relax_free(i, g);
}
