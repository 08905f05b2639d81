// Not exact: the order of a subgroup's sum is the device's.
#version 450
#extension GL_KHR_shader_subgroup_arithmetic : require
layout(local_size_x = 32) in;
layout(std430, binding = 0) buffer Values { float value[]; };
void main() { value[gl_GlobalInvocationID.x] = subgroupAdd(value[gl_GlobalInvocationID.x]); }
