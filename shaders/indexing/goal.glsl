// Stage goal for one vertex, shared by goal.comp and update.comp.
#ifndef FASCICLE_INDEXING_GOAL_GLSL
#define FASCICLE_INDEXING_GOAL_GLSL
#include "shaders/indexing/buffers.glsl"
#include "shaders/kernel/goal.inc"

// What a vertex reads from one of its regions.
struct Pull {
  float share;
  Transform region;
};

Pull load_pull(uint i, uint entry) {
  uint word = share_given[entry];
  Pull p;
  p.share = share_of(word);
  p.region = load_transform(neighbour_of(i, entry, word));
  return p;
}

Vector blended_goal(uint i) {
  Transform own = load_transform(i);
  Transform blend = own;
  uint entry = ring_start(i);
  uint left = ring_size(i);
  for (; left >= ahead; left -= ahead) {
    Pull p[ahead];
    for (uint j = 0u; j < ahead; ++j) p[j] = load_pull(i, entry + j * ring_stride);
    for (uint j = 0u; j < ahead; ++j) blend = goal_add(blend, p[j].share, p[j].region, own);
    entry += ahead * ring_stride;
  }
  for (; left > 0u; --left) {
    Pull p = load_pull(i, entry);
    blend = goal_add(blend, p.share, p.region, own);
    entry += ring_stride;
  }
  return goal_position(blend, vector_of(rest[i]));
}

#endif
