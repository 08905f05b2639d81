// Not exact: the value read before the addition reveals the order of the invocations.
#version 450
layout(local_size_x = 32) in;
layout(std430, binding = 0) buffer Values { uint value[]; };
void main() { value[gl_GlobalInvocationID.x + 1u] = atomicAdd(value[0], 1u); }
