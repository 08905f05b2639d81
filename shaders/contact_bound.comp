// Stage contact, first: boxes around the tetrahedra, and empty chains. One invocation per leaf.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/contact.glsl"

void main() {
  uint leaf = item_index();
  if (leaf >= leaf_count()) return;
  uint first = leaf * contact_leaf;
  uint end = first + contact_leaf;
  if (end > push.substep.contact_tetrahedron_count) end = push.substep.contact_tetrahedron_count;
  vec4 low = nothing_is_lower;
  vec4 high = nothing_is_higher;
  for (uint t = first; t < end; ++t) {
    contact_first[t] = no_contact;
    uvec4 corners = contact_tetrahedron[t];
    for (uint k = 0u; k < 4u; ++k) {
      vec4 x = record_of(place_of(corners[k]));
      low = lower(low, x);
      high = higher(high, x);
    }
  }
  contact_box[2u * leaf] = low;
  contact_box[2u * leaf + 1u] = high;
}
