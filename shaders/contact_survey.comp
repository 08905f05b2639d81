// Stage contact, fourth: between which tetrahedra the finds of a block of points lie. One invocation a block.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/contact.glsl"

void main() {
  uint block = item_index();
  if (block >= block_count()) return;
  uint end = (block + 1u) * contact_block;
  if (end > push.substep.contact_count) end = push.substep.contact_count;
  uint lowest = no_contact;
  uint highest = 0u;
  for (uint p = block * contact_block; p < end; ++p) {
    uint t = contact_found[p];
    if (t >= push.substep.contact_tetrahedron_count) continue;
    if (t < lowest) lowest = t;
    if (t > highest) highest = t;
  }
  contact_range[block] = uvec2(lowest, highest);
}
