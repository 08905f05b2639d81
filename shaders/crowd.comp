// Stage limit, second of a pass: the number of tetrahedra at a vertex that lack volume, times its mobility; and a copy
// of its position. One invocation per vertex.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/limit.glsl"

void main() {
  uint i = item_index();
  if (i >= push.substep.vertex_count) return;
  float count = 0.0f;
  for (uint e = limit_offset[i]; e < limit_offset[i + 1u]; ++e)
    if (lack[limit_entry[e] >> 2u] > 0.0f) count += 1.0f;
  limit_load[i] = count * mobility[i];
  iterate_before[i] = position[i];
}
