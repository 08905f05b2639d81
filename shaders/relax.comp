// Stage relax: one invocation per vertex.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/relax.glsl"

void main() {
  uint i = item_index();
  if (i >= push.substep.vertex_count) return;
  if (!is_kinematic(i)) relax_free(i, vector_of(goal[i]));
}
