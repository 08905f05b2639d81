// Stage contact, fourth: puts each point that has found a tetrahedron at the head of that one's chain. One invocation
// per point.
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
