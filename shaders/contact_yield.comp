// Stage contact within the implicit integrator's iterations: moves a vertex by the impulses that hold its points. One
// invocation per vertex.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/contact_sum.glsl"

void main() {
  uint i = item_index();
  if (i >= push.substep.vertex_count) return;
  Vector sum;
  if (is_kinematic(i) || !is_in_contact(i, sum)) return;
  Response answer = response[push.implicit.first_response + i];
  Vector move = contact_gain(sum, contact_yielding(mobility[i], answer.to_inertia));
  position[i] = record_of(contact_changed(vector_of(position[i]), move));
  goal[i] = record_of(contact_goal(vector_of(goal[i]), move, answer.to_goal));
}
