// Stage limit, first of a pass: how much volume each tetrahedron lacks. One invocation per tetrahedron.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/limit.glsl"

void main() {
  uint t = item_index();
  if (t >= push.implicit.limit_count) return;
  Limit l = limit[t];
  LimitVolume v = limit_volume(vector_of(position[l.corner_a]), vector_of(position[l.corner_b]),
                               vector_of(position[l.corner_c]), vector_of(position[l.corner_d]), l.inverse_size);
  float least = l.least;
  if (limit_lack(v.volume, least) > 0.0f) {
    LimitVolume before = limit_volume(vector_of(position_before[l.corner_a]), vector_of(position_before[l.corner_b]),
                                      vector_of(position_before[l.corner_c]), vector_of(position_before[l.corner_d]),
                                      l.inverse_size);
    least = limit_least(least, before.volume, push.implicit.step);
  }
  lack[t] = limit_lack(v.volume, least);
}
