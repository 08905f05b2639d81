// Stage predict for one vertex, shared by predict.comp and update.comp.
#ifndef FASCICLE_INDEXING_PREDICT_GLSL
#define FASCICLE_INDEXING_PREDICT_GLSL
#include "shaders/indexing/skeleton.glsl"
#include "shaders/kernel/predict.inc"

// The velocity of free vertex i with the external forces in.
Vector predicted_velocity(uint i) {
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
  Vector v = vector_of(velocity[i]);
  if (with_carried)
    v = carry_velocity(v, vertex[i].carried, velocity_of_skin(i), vector_of(skinned_velocity_before[i]));
  return predict_velocity(v, a, push.substep.h);
}

#endif
