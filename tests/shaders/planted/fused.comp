// Not exact: a fused multiply-add.
#version 450
layout(local_size_x = 32) in;
layout(std430, binding = 0) buffer Values { float value[]; };
void main() {
  uint i = gl_GlobalInvocationID.x;
  value[i] = fma(value[i], value[i], value[i]);
}
