// Stage integrate: one invocation per vertex.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/integrate.glsl"

void main() {
  uint i = item_index();
  if (i >= push.substep.vertex_count) return;
  if (with_implicit)
    finish_implicit(i);
  else if (is_kinematic(i))
    move_kinematic(i);
  else
    move_free(i, vector_of(velocity[i]), vector_of(goal[i]));
}
