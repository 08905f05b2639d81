// Stage integrate for one vertex, shared by integrate.comp and update.comp.
#ifndef FASCICLE_INDEXING_INTEGRATE_GLSL
#define FASCICLE_INDEXING_INTEGRATE_GLSL
#include "shaders/indexing/buffers.glsl"
#include "shaders/kernel/integrate.inc"

// The velocity that skinning alone would give vertex i.
Vector velocity_of_skin(uint i) {
  Vector u = zero_vector();
  if (has_skeleton())
    u = skinned_velocity(vector_of(skinned[i]), vector_of(skinned_before[i]), push.substep.inverse_h);
  return u;
}

void move_free(uint i, Vector v, Vector g) {
  Vector q = vector_of(position[i]);
  float alpha_over_h = vertex[i].alpha * push.substep.inverse_h;
  v = integrate_velocity(v, q, g, alpha_over_h, velocity_of_skin(i), decay[vertex[i].tag & tag_layer_mask]);
  velocity[i] = record_of(v);
  position[i] = record_of(integrate_position(q, v, push.substep.h));
}

void move_kinematic(uint i) {
  velocity[i] = record_of(velocity_of_skin(i));
  if (has_skeleton()) position[i] = skinned[i];
}

#endif
