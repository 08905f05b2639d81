// Stage contact, last: applies the impulses of its contacts to a vertex. One invocation per vertex.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/contact_sum.glsl"

void main() {
  uint i = item_index();
  if (i >= push.substep.vertex_count) return;
  Vector sum;
  if (!is_in_contact(i, sum)) return;
  Vector gain = contact_gain(sum, mobility[i]);
  position[i] = record_of(contact_moved(vector_of(position[i]), gain, push.substep.h));
  velocity[i] = record_of(contact_changed(vector_of(velocity[i]), gain));
}
