// Not exact: an extended instruction.
#version 450
layout(local_size_x = 32) in;
layout(std430, binding = 0) buffer Values { float value[]; };
void main() { value[gl_GlobalInvocationID.x] = sqrt(value[gl_GlobalInvocationID.x]); }
