// The sum of a vertex's impulses: first from its own contact, then from those in its tetrahedra.
#ifndef FASCICLE_INDEXING_CONTACT_SUM_GLSL
#define FASCICLE_INDEXING_CONTACT_SUM_GLSL
#include "shaders/indexing/contact_gather.glsl"

// Whether vertex i takes part in a contact.
bool is_in_contact(uint i, out Vector sum) {
  sum = zero_vector();
  bool first = true;
  uint own = contact_number[i];
  if (own != no_contact && is_found(own)) {
    sum = vector_of(contact_impulse_of[own]);
    first = false;
  }
  for (uint e = contact_offset[i]; e < contact_offset[i + 1u]; ++e) {
    uint t = contact_entry[e] >> 2u;
    for (uint p = point_from(t, 0u); p != no_contact; p = point_from(t, p + 1u)) {
      Vector term = scaled_vector(-weight_of(p, contact_entry[e] & 3u), vector_of(contact_impulse_of[p]));
      if (first) sum = term;
      else sum = vector_sum(sum, term);
      first = false;
    }
  }
  return !first;
}

#endif
