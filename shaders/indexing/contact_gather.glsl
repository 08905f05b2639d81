// The contacts of one tetrahedron, in the order of their points.
#ifndef FASCICLE_INDEXING_CONTACT_GATHER_GLSL
#define FASCICLE_INDEXING_CONTACT_GATHER_GLSL
#include "shaders/indexing/contact.glsl"

bool is_found(uint p) { return contact_found[p] < push.substep.contact_tetrahedron_count; }

// The first and one past the last of the blocks of points that may have found tetrahedron t.
uvec2 blocks_of(uint t) {
  uvec2 blocks = contact_blocks[t / contact_leaf];
  return uvec2(blocks.x, blocks.y < block_count() ? blocks.y : block_count());
}

// The first and one past the last of a block's points, if one of them may have found tetrahedron t.
uvec2 points_of(uint block, uint t) {
  uvec2 range = contact_range[block];
  if (t < range.x || t > range.y) return uvec2(0u, 0u);
  uint end = (block + 1u) * contact_block;
  return uvec2(block * contact_block, end < push.substep.contact_count ? end : push.substep.contact_count);
}

#endif
