// Before a frame's first substep: makes positions and skinned positions relative to the frame's new origin.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/buffers.glsl"
#include "shaders/kernel/predict.inc"

void main() {
  uint i = item_index();
  if (i >= push.substep.vertex_count) return;
  Vector shift;
  shift.x = push.substep.shift_x;
  shift.y = push.substep.shift_y;
  shift.z = push.substep.shift_z;
  position[i] = record_of(rebase(vector_of(position[i]), shift));
  if (with_implicit) position_before[i] = record_of(rebase(vector_of(position_before[i]), shift));
  if (has_skeleton()) skinned[i] = record_of(rebase(vector_of(skinned[i]), shift));
}
