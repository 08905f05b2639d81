// Copies 16 bytes per invocation from one buffer to another: measures a device's memory bandwidth, for fascicle bench.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/buffers.glsl"

void main() {
  uint i = item_index();
  if (i >= push.substep.vertex_count) return;
  velocity[i] = position[i];
}
