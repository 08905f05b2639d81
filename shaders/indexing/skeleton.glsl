// The skeleton's motion at one vertex, shared by stages predict and integrate.
#ifndef FASCICLE_INDEXING_SKELETON_GLSL
#define FASCICLE_INDEXING_SKELETON_GLSL
#include "shaders/indexing/buffers.glsl"
#include "shaders/kernel/skin.inc"

// The velocity that skinning alone would give vertex i.
Vector velocity_of_skin(uint i) {
  Vector u = zero_vector();
  if (has_skeleton())
    u = skinned_velocity(vector_of(skinned[i]), vector_of(skinned_before[i]), push.substep.inverse_h);
  return u;
}

#endif
