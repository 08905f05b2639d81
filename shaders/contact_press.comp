// Stage contact, sixth: the impulse of each contact. One invocation per point.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/contact_pair.glsl"

float load_of(uint i) {
  return contact_load(mobility[i], contact_crowd[i]);
}

void main() {
  uint p = item_index();
  if (p >= push.substep.contact_count) return;
  Vector impulse = zero_vector();
  if (is_found(p)) {
    ContactPoint point = contact[p];
    uvec4 corners = corners_of(p);
    ContactWeights w = weights_of(p);
    Vector u = contact_velocity(w, vector_of(velocity[point.vertex]), vector_of(velocity[corners.x]),
                                vector_of(velocity[corners.y]), vector_of(velocity[corners.z]),
                                vector_of(velocity[corners.w]));
    float load = load_of(point.vertex) + contact_mean(w, load_of(corners.x), load_of(corners.y), load_of(corners.z),
                                                      load_of(corners.w));
    impulse = contact_impulse(push_of(p), u, push.substep.inverse_h, point.friction, load);
  }
  contact_impulse_of[p] = record_of(impulse);
}
