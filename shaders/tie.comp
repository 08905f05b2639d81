// Stage tie: one invocation per vertex.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/buffers.glsl"
#include "shaders/kernel/tie.inc"

Vector place_of(uint i) {
  Vector x = vector_of(position[i]);
  if (with_implicit) x = place_ahead(x, vector_of(velocity[i]), push.substep.h);
  return x;
}

Vector entry_term(uint i, uint entry) {
  Tie t = tie[tie_index[entry]];
  TiePush p = tie_push(place_of(t.sliding), place_of(t.corner_a), place_of(t.corner_b), place_of(t.corner_c),
                       t.mobility_a, t.mobility_b, t.mobility_c, t.rest_height);
  float of_corner = i == t.corner_a ? p.of_a : i == t.corner_b ? p.of_b : p.of_c;
  float weight = i == t.sliding ? -tie_coefficient[entry] : tie_coefficient[entry] * of_corner;
  return scaled_vector(weight, p.push);
}

void main() {
  uint i = item_index();
  if (i >= push.substep.vertex_count) return;
  uint first = tie_offset[i];
  uint end = tie_offset[i + 1u];
  Vector a = zero_vector();
  if (first < end) {
    Vector sum = entry_term(i, first);
    for (uint entry = first + 1u; entry < end; ++entry) sum = vector_sum(sum, entry_term(i, entry));
    a = tie_acceleration(sum, push.substep.inverse_h);
  }
  tied[i] = record_of(a);
}
