// Stage contact, sixth: the sum of a vertex's coefficients in all contacts. One invocation a vertex.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/contact_gather.glsl"

void main() {
  uint i = item_index();
  if (i >= push.substep.vertex_count) return;
  float sum = 0.0f;
  uint own = contact_number[i];
  if (own != no_contact && is_found(own)) sum = 1.0f;
  for (uint e = contact_offset[i]; e < contact_offset[i + 1u]; ++e) {
    uint t = contact_entry[e] >> 2u;
    uvec2 points = points_of(t);
    for (uint p = points.x; p < points.y; ++p)
      if (contact_found[p] == t) sum += weight_of(p, contact_entry[e] & 3u);
  }
  contact_crowd[i] = sum;
}
