// Refused: arithmetic on vectors.
#version 450
layout(local_size_x = 32) in;
layout(std430, binding = 0) buffer Values { vec4 value[]; };
void main() {
  uint i = gl_GlobalInvocationID.x;
  value[i] = value[i] + value[i];
}
