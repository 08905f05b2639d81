// Stage limit, last of a pass: vertices of tetrahedra that lack volume move apart. One invocation per vertex.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/limit.glsl"

Vector entry_term(uint entry) {
  uint t = entry >> 2u;
  uint corner = entry & 3u;
  Limit l = limit[t];
  LimitVolume v =
      limit_volume(vector_of(iterate_before[l.corner_a]), vector_of(iterate_before[l.corner_b]),
                   vector_of(iterate_before[l.corner_c]), vector_of(iterate_before[l.corner_d]), l.inverse_size);
  float p = limit_push(v, lack[t], limit_load[l.corner_a], limit_load[l.corner_b], limit_load[l.corner_c],
                       limit_load[l.corner_d], l.least_square, l.size);
  Vector gradient = v.by_d;
  if (corner == 0u) gradient = limit_first_gradient(v);
  if (corner == 1u) gradient = v.by_b;
  if (corner == 2u) gradient = v.by_c;
  return limit_term(p, gradient);
}

void main() {
  uint i = item_index();
  if (i >= push.substep.vertex_count) return;
  if (!(limit_load[i] > 0.0f)) return;
  Vector sum = zero_vector();
  bool first = true;
  for (uint e = limit_offset[i]; e < limit_offset[i + 1u]; ++e) {
    uint entry = limit_entry[e];
    if (!(lack[entry >> 2u] > 0.0f)) continue;
    Vector term = entry_term(entry);
    if (first) sum = term;
    else sum = vector_sum(sum, term);
    first = false;
  }
  Vector move = limit_move(sum, mobility[i]);
  position[i] = record_of(limit_moved(vector_of(position[i]), move));
  predicted[i] = record_of(limit_moved(vector_of(predicted[i]), move));
  goal[i] = record_of(limit_moved(vector_of(goal[i]), move));
  velocity[i] = record_of(limit_velocity(vector_of(velocity[i]), move, push.implicit.inverse_step));
}
