// Stage goal for one vertex, shared by goal.comp and update.comp.
#ifndef FASCICLE_INDEXING_GOAL_GLSL
#define FASCICLE_INDEXING_GOAL_GLSL
#include "shaders/indexing/buffers.glsl"
#include "shaders/kernel/goal.inc"

Vector blended_goal(uint i) {
  Transform own = load_transform(i);
  Transform blend = own;
  uint entry = ring_start(i);
  uint degree = vertex[i].degree;
  for (uint k = 0u; k < degree; ++k) {
    blend = goal_add(blend, share_given[entry], load_transform(ring[entry]), own);
    entry += ring_stride;
  }
  return goal_position(blend, vector_of(rest[i]));
}

#endif
