// Stage contact, last: what the impulses of its own contact, then of those in its tetrahedra do to a vertex. One
// invocation a vertex.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/contact_gather.glsl"

void main() {
  uint i = item_index();
  if (i >= push.substep.vertex_count) return;
  Vector sum = zero_vector();
  bool first = true;
  uint own = contact_number[i];
  if (own != no_contact && is_found(own)) {
    sum = vector_of(contact_impulse_of[own]);
    first = false;
  }
  for (uint e = contact_offset[i]; e < contact_offset[i + 1u]; ++e) {
    uint t = contact_entry[e] >> 2u;
    uvec2 blocks = blocks_of(t);
    for (uint block = blocks.x; block < blocks.y; ++block) {
      uvec2 points = points_of(block, t);
      for (uint p = points.x; p < points.y; ++p) {
        if (contact_found[p] != t) continue;
        Vector term = scaled_vector(-weight_of(p, contact_entry[e] & 3u), vector_of(contact_impulse_of[p]));
        if (first) sum = term;
        else sum = vector_sum(sum, term);
        first = false;
      }
    }
  }
  if (first) return;
  Vector gain = contact_gain(sum, mobility[i]);
  position[i] = record_of(contact_moved(vector_of(position[i]), gain, push.substep.h));
  velocity[i] = record_of(contact_changed(vector_of(velocity[i]), gain));
  if (with_implicit) velocity_before[i] = record_of(contact_changed(vector_of(velocity_before[i]), gain));
}
