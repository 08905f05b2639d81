// A point and the tetrahedron that it lies in.
#ifndef FASCICLE_INDEXING_CONTACT_PAIR_GLSL
#define FASCICLE_INDEXING_CONTACT_PAIR_GLSL
#include "shaders/indexing/contact_gather.glsl"

uvec4 corners_of(uint p) { return contact_tetrahedron[contact_found[p]]; }

ContactWeights weights_of(uint p) {
  vec4 place = contact_place[3u * p];
  ContactWeights w;
  w.a = place.x;
  w.b = place.y;
  w.c = place.z;
  w.d = place.w;
  return w;
}

Vector normal_of(uint p) { return vector_of(contact_place[3u * p + 2u]); }

ContactPush push_of(uint p) {
  ContactPush r;
  r.push = vector_of(contact_place[3u * p + 1u]);
  r.normal = normal_of(p);
  return r;
}

#endif
