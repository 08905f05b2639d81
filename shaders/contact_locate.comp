// Stage contact, fifth: between which blocks the points lie that found a leaf's tetrahedra. One invocation a leaf.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/contact.glsl"

void main() {
  uint leaf = item_index();
  if (leaf >= leaf_count()) return;
  uint first = leaf * contact_leaf;
  uint blocks = block_count();
  uint from = blocks;
  uint to = 0u;
  for (uint block = 0u; block < blocks; ++block) {
    uvec2 range = contact_range[block];
    if (range.x >= first + contact_leaf || range.y < first) continue;
    if (from == blocks) from = block;
    to = block + 1u;
  }
  contact_blocks[leaf] = uvec2(from, to);
}
