// Stage contact, fourth: each point that has found a tetrahedron is put at the head of its chain. One invocation a
// point.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/contact.glsl"

void main() {
  uint p = item_index();
  if (p >= push.substep.contact_count) return;
  uint t = contact_found[p];
  if (t >= push.substep.contact_tetrahedron_count) return;
  contact_next[p] = atomicExchange(contact_first[t], p);
}
