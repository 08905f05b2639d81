// The contacts of one tetrahedron, in the order of their points.
#ifndef FASCICLE_INDEXING_CONTACT_GATHER_GLSL
#define FASCICLE_INDEXING_CONTACT_GATHER_GLSL
#include "shaders/indexing/contact.glsl"

bool is_found(uint p) { return contact_found[p] < push.substep.contact_tetrahedron_count; }

// The lowest point from `from` on that has found tetrahedron t; no_contact if there is none. Chains are short and
// unordered.
uint point_from(uint t, uint from) {
  uint lowest = no_contact;
  for (uint p = contact_first[t]; p < push.substep.contact_count; p = contact_next[p])
    if (p >= from && p < lowest) lowest = p;
  return lowest;
}

#endif
