// Stage integrate for one vertex, shared by integrate.comp and update.comp.
#ifndef FASCICLE_INDEXING_INTEGRATE_GLSL
#define FASCICLE_INDEXING_INTEGRATE_GLSL
#include "shaders/indexing/skeleton.glsl"
#include "shaders/kernel/integrate.inc"

void move_free(uint i, Vector v, Vector g) {
  Vector q = vector_of(position[i]);
  float alpha_over_h = alpha[i] * push.substep.inverse_h;
  Vector u = velocity_of_skin(i);
  v = integrate_velocity(v, q, g, alpha_over_h, u, decay[layer_of(i)]);
  if (with_carried) skinned_velocity_before[i] = record_of(u);
  velocity[i] = record_of(v);
  position[i] = record_of(integrate_position(q, v, push.substep.h));
}

void move_kinematic(uint i) {
  Vector u = velocity_of_skin(i);
  if (with_carried) skinned_velocity_before[i] = record_of(u);
  velocity[i] = record_of(u);
  if (has_skeleton()) position[i] = skinned[i];
}

// For the implicit integrator: the position is known, the velocity follows.
void finish_implicit(uint i) {
  Vector u = velocity_of_skin(i);
  if (with_carried) skinned_velocity_before[i] = record_of(u);
  vec4 v = record_of(u);
  if (!is_kinematic(i))
    v = record_of(pulled_velocity(vector_of(velocity[i]), vector_of(position[i]), vector_of(predicted[i]),
                                  vector_of(goal[i]), response[push.implicit.first_response + i].to_goal,
                                  push.implicit.inverse_step));
  velocity[i] = v;
}

#endif
