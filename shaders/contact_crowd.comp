// Stage contact, fifth: the sum of a vertex's coefficients in all contacts. One invocation per vertex.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/contact_gather.glsl"

void main() {
  uint i = item_index();
  if (i >= push.substep.vertex_count) return;
  float sum = 0.0f;
  bool first = true;
  uint own = contact_number[i];
  if (own != no_contact && is_found(own)) {
    sum = 1.0f;
    first = false;
  }
  for (uint e = contact_offset[i]; e < contact_offset[i + 1u]; ++e) {
    uint t = contact_entry[e] >> 2u;
    for (uint p = point_from(t, 0u); p != no_contact; p = point_from(t, p + 1u)) {
      float weight = weight_of(p, contact_entry[e] & 3u);
      if (first) sum = weight;
      else sum = sum + weight;
      first = false;
    }
  }
  contact_crowd[i] = sum;
}
