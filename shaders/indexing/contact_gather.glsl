// The contacts of one tetrahedron, in the order of their points.
#ifndef FASCICLE_INDEXING_CONTACT_GATHER_GLSL
#define FASCICLE_INDEXING_CONTACT_GATHER_GLSL
#include "shaders/indexing/contact.glsl"

bool is_found(uint p) { return contact_found[p] < push.substep.contact_tetrahedron_count; }

// The first and one past the last of the points that may have found tetrahedron t.
uvec2 points_of(uint t) {
  uvec2 blocks = contact_blocks[t / contact_leaf];
  uint end = blocks.y * contact_block;
  return uvec2(blocks.x * contact_block, end < push.substep.contact_count ? end : push.substep.contact_count);
}

#endif
