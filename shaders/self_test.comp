// The self-test: one invocation per row of the table, self_test_results results each.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/buffers.h"
#include "shaders/kernel/self_test.inc"

layout(local_size_x = slice_width) in;

layout(push_constant, std430) uniform PushBlock { Push push; };
layout(std430, binding = buffer_self_test_input) readonly buffer InputBuffer { SelfTestInput table[]; };
layout(std430, binding = buffer_self_test_result) writeonly buffer ResultBuffer { float result[]; };

void main() {
  uint row = (push.first_slice + gl_WorkGroupID.x) * slice_width + gl_LocalInvocationID.x;
  if (row >= push.substep.vertex_count) return;
  SelfTestInput t = table[row];
  uint at = row * self_test_results;
  for (int operation = 0; operation < int(self_test_scalars); ++operation)
    result[at++] = self_test_scalar(operation, t.x, t.y, t.z, t.w);
  for (int operation = 0; operation < int(self_test_positives); ++operation)
    result[at++] = self_test_positive(operation, absolute(t.x) + 0.25f);
  Quaternion qcp = extract_rotation(t.q, t.a, false);
  result[at++] = qcp.w;
  result[at++] = qcp.x;
  result[at++] = qcp.y;
  result[at++] = qcp.z;
  Quaternion mueller = extract_rotation(t.q, t.a, true);
  result[at++] = mueller.w;
  result[at++] = mueller.x;
  result[at++] = mueller.y;
  result[at++] = mueller.z;
}
