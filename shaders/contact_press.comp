// Stage contact, seventh: the impulse of each contact. One invocation a point.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/contact_gather.glsl"

float load_of(uint i) {
  return contact_load(mobility[i], contact_crowd[i]);
}

void main() {
  uint p = item_index();
  if (p >= push.substep.contact_count) return;
  Vector impulse = zero_vector();
  if (is_found(p)) {
    ContactPoint point = contact[p];
    uvec4 corners = contact_tetrahedron[contact_found[p]];
    ContactWeights w;
    w.a = contact_place[3u * p].x;
    w.b = contact_place[3u * p].y;
    w.c = contact_place[3u * p].z;
    w.d = contact_place[3u * p].w;
    ContactPush push_out;
    push_out.push = vector_of(contact_place[3u * p + 1u]);
    push_out.normal = vector_of(contact_place[3u * p + 2u]);
    Vector u = contact_velocity(w, vector_of(velocity[point.vertex]), vector_of(velocity[corners.x]),
                                vector_of(velocity[corners.y]), vector_of(velocity[corners.z]),
                                vector_of(velocity[corners.w]));
    float load = load_of(point.vertex) + contact_mean(w, load_of(corners.x), load_of(corners.y), load_of(corners.z),
                                                      load_of(corners.w));
    impulse = contact_impulse(push_out, u, push.substep.inverse_h, point.friction, load);
  }
  contact_impulse_of[p] = record_of(impulse);
}
