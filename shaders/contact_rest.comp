// Stage contact after the implicit integrator's velocities: applies the impulses that settle its contacts to a vertex's
// velocity. One invocation per vertex.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/contact_sum.glsl"

void main() {
  uint i = item_index();
  if (i >= push.substep.vertex_count) return;
  Vector sum;
  if (is_kinematic(i) || !is_in_contact(i, sum)) return;
  velocity[i] = record_of(contact_changed(vector_of(velocity[i]), contact_gain(sum, mobility[i])));
}
