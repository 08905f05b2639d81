// Stage contact within the implicit integrator's iterations: the impulse that holds each point. One invocation per
// point.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/contact_pair.glsl"

float part_of(uint i) {
  float to_inertia = response[push.implicit.first_response + i].to_inertia;
  return contact_part(contact_yielding(mobility[i], to_inertia), contact_crowd[i]);
}

// The displacement since the substep began.
Vector way_of(uint i) {
  return subtract(vector_of(position[i]), vector_of(position_before[i]));
}

void main() {
  uint p = item_index();
  if (p >= push.substep.contact_count) return;
  Vector impulse = zero_vector();
  if (is_found(p)) {
    ContactPoint point = contact[p];
    uvec4 corners = corners_of(p);
    ContactWeights w = weights_of(p);
    Vector moved = contact_velocity(w, way_of(point.vertex), way_of(corners.x), way_of(corners.y), way_of(corners.z),
                                    way_of(corners.w));
    float load = part_of(point.vertex) + contact_mean(w, part_of(corners.x), part_of(corners.y), part_of(corners.z),
                                                      part_of(corners.w));
    impulse = contact_hold_impulse(push_of(p), moved, push.implicit.step, point.margin, point.friction, load);
  }
  contact_impulse_of[p] = record_of(impulse);
}
