// Shared by the shaders of stage limit.
#ifndef FASCICLE_INDEXING_LIMIT_GLSL
#define FASCICLE_INDEXING_LIMIT_GLSL
#include "shaders/indexing/buffers.glsl"
#include "shaders/kernel/limit.inc"

layout(std430, binding = buffer_limit) readonly buffer LimitBuffer { Limit limit[]; };
layout(std430, binding = buffer_limit_offset) readonly buffer LimitOffsetBuffer { uint limit_offset[]; };
layout(std430, binding = buffer_limit_entry) readonly buffer LimitEntryBuffer { uint limit_entry[]; };
layout(std430, binding = buffer_mobility) readonly buffer MobilityBuffer { float mobility[]; };
layout(std430, binding = buffer_lack) buffer LackBuffer { float lack[]; };
layout(std430, binding = buffer_limit_load) buffer LimitLoadBuffer { float limit_load[]; };

#endif
