// Stage predict for one vertex, shared by predict.comp and update.comp.
#ifndef FASCICLE_INDEXING_PREDICT_GLSL
#define FASCICLE_INDEXING_PREDICT_GLSL
#include "shaders/indexing/buffers.glsl"
#include "shaders/kernel/predict.inc"

// The velocity of free vertex i with the external forces in.
Vector predicted_velocity(uint i) {
  Vector a;
  a.x = push.substep.gravity_x;
  a.y = push.substep.gravity_y;
  a.z = push.substep.gravity_z;
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
  return predict_velocity(vector_of(velocity[i]), a, push.substep.h);
}

#endif
