// Stage goal: one invocation per vertex.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/goal.glsl"

void main() {
  uint i = item_index();
  if (i >= push.substep.vertex_count) return;
  goal[i] = record_of(blended_goal(i));
}
