// Stage contact after the implicit integrator's velocities: the impulse that brings each pressing contact to rest. One
// invocation per point.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/contact_pair.glsl"

float part_of(uint i) {
  return mobility[i] * contact_crowd[i];
}

void main() {
  uint p = item_index();
  if (p >= push.substep.contact_count) return;
  if (!is_found(p)) return;
  uint s = contact[p].vertex;
  uvec4 corners = corners_of(p);
  ContactWeights w = weights_of(p);
  Vector u = contact_velocity(w, vector_of(velocity[s]), vector_of(velocity[corners.x]),
                              vector_of(velocity[corners.y]), vector_of(velocity[corners.z]),
                              vector_of(velocity[corners.w]));
  Vector before = contact_velocity(w, vector_of(velocity_before[s]), vector_of(velocity_before[corners.x]),
                                   vector_of(velocity_before[corners.y]), vector_of(velocity_before[corners.z]),
                                   vector_of(velocity_before[corners.w]));
  float load = part_of(s) + contact_mean(w, part_of(corners.x), part_of(corners.y), part_of(corners.z),
                                         part_of(corners.w));
  load = contact_settled_load(load, w, mobility[corners.x], mobility[corners.y], mobility[corners.z],
                              mobility[corners.w]);
  contact_impulse_of[p] = record_of(contact_settling(vector_of(contact_impulse_of[p]), normal_of(p), u, before,
                                                     push.implicit.settled, load));
}
