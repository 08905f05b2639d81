// Refused: conversions round differently on devices.
#version 450
layout(local_size_x = 32) in;
layout(std430, binding = 0) buffer Values { float value[]; };
void main() { value[gl_GlobalInvocationID.x] = float(gl_GlobalInvocationID.x); }
