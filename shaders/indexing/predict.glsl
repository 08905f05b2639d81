// Stage predict for one vertex, shared by predict.comp and update.comp.
#ifndef FASCICLE_INDEXING_PREDICT_GLSL
#define FASCICLE_INDEXING_PREDICT_GLSL
#include "shaders/indexing/skeleton.glsl"
#include "shaders/kernel/predict.inc"
#include "shaders/kernel/tie.inc"

// Acceleration of vertex i by gravity, the scene's forces and ties.
Vector external_acceleration(uint i) {
  Vector a;
  a.x = push.substep.gravity_x;
  a.y = push.substep.gravity_y;
  a.z = push.substep.gravity_z;
  if (has_skeleton()) a = add_gravity(a, vector_of(gravity[i]));
  if (with_forces) {
    uint end = force_offset[i + 1u];
    for (uint k = force_offset[i]; k < end; ++k) {
      Force f = force[push.substep.first_force + force_index[k]];
      Vector direction;
      direction.x = f.x;
      direction.y = f.y;
      direction.z = f.z;
      a = add_force(a, force_coefficient[k], direction);
    }
  }
  if (with_ties) a = vector_sum(a, vector_of(tied[i]));
  return a;
}

// The velocity of free vertex i, external forces included.
Vector predicted_velocity(uint i) {
  Vector a = external_acceleration(i);
  Vector v = vector_of(velocity[i]);
  if (with_carried)
    v = carry_velocity(v, carried[i], velocity_of_skin(i), vector_of(skinned_velocity_before[i]));
  return predict_velocity(v, a, push.substep.h);
}

// For the implicit integrator: y, and the position where its iterations start.
void begin_implicit(uint i) {
  vec4 q = position[i];
  Vector q_before = vector_of(position_before[i]);
  position_before[i] = q;
  Vector v = vector_of(velocity[i]);
  Vector v_before = vector_of(velocity_before[i]);
  velocity_before[i] = velocity[i];
  if (is_kinematic(i)) {
    if (has_skeleton()) position[i] = skinned[i];
    predicted[i] = position[i];
    iterate_before[i] = position[i];
    return;
  }
  Vector a = external_acceleration(i);
  Vector u = velocity_of_skin(i);
  if (with_carried) {
    Vector before = vector_of(skinned_velocity_before[i]);
    a = carry_acceleration(a, carried[i] * push.substep.inverse_h, u, before);
    u = with_history(u, before, push.implicit.skin_history);
  }
  Response answer = response[push.implicit.first_response + i];
  Vector v_y = predict_damped(with_history(v, v_before, push.implicit.history), a, u, push.implicit.step, answer.kept,
                              answer.dragged);
  predicted[i] =
      record_of(predict_position(vector_of(q), q_before, push.implicit.history, v_y, push.implicit.step));
  velocity[i] = record_of(v_y);
  Vector start = start_position(vector_of(q), v, v_before, a, u, push.substep.h, push.substep.inverse_h,
                                push.implicit.start, push.implicit.extrapolated, answer.kept, answer.dragged);
  position[i] = record_of(start);
  iterate_before[i] = record_of(start);
}

#endif
