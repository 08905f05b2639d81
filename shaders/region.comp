// Stage region: one invocation per region.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/buffers.glsl"
#include "shaders/kernel/region.inc"
#include "shaders/kernel/volume.inc"

RegionSum no_terms() {
  RegionSum sum;
  sum.s = zero_vector();
  sum.a.xx = 0.0f;
  sum.a.xy = 0.0f;
  sum.a.xz = 0.0f;
  sum.a.yx = 0.0f;
  sum.a.yy = 0.0f;
  sum.a.yz = 0.0f;
  sum.a.zx = 0.0f;
  sum.a.zy = 0.0f;
  sum.a.zz = 0.0f;
  return sum;
}

// What a region reads from one neighbour.
struct Neighbour {
  float share;
  vec4 place;
  vec4 record;  // of buffer_rest
};

Neighbour load_neighbour(uint r, uint entry) {
  uint word = share_taken[entry];
  uint i = neighbour_of(r, entry, word);
  Neighbour n;
  n.share = share_of(word);
  n.place = position[i];
  n.record = rest[i];
  return n;
}

RegionSum neighbour_term(Neighbour n, Vector q, Vector q0) {
  return region_term(n.share * n.record.w, subtract(vector_of(n.place), q), subtract(vector_of(n.record), q0));
}

// `degree` is at least 1. Several neighbours are loaded before the first is used.
RegionSum sum_of_neighbours(uint r, uint degree, Vector q, Vector q0) {
  uint entry = ring_start(r);
  RegionSum sum = neighbour_term(load_neighbour(r, entry), q, q0);
  entry += ring_stride;
  uint left = degree - 1u;
  for (; left >= ahead; left -= ahead) {
    Neighbour n[ahead];
    for (uint j = 0u; j < ahead; ++j) n[j] = load_neighbour(r, entry + j * ring_stride);
    for (uint j = 0u; j < ahead; ++j) sum = region_add(sum, neighbour_term(n[j], q, q0));
    entry += ahead * ring_stride;
  }
  for (; left > 0u; --left) {
    sum = region_add(sum, neighbour_term(load_neighbour(r, entry), q, q0));
    entry += ring_stride;
  }
  return sum;
}

Muscle muscle_of(uint entry) { return muscle[push.substep.first_muscle + region_muscle[entry].muscle]; }

float bulge_of(Vector n, uint entry) {
  Muscle m = muscle_of(entry);
  Vector tau;
  tau.x = m.tau_x;
  tau.y = m.tau_y;
  tau.z = m.tau_z;
  return muscle_bulge(n, region_muscle[entry].bulge, tau, m.swell);
}

float shear_of(uint entry) { return region_muscle[entry].shear * muscle_of(entry).twist; }

// `first` is less than `end`.
Matrix scale_of_muscles(uint r, uint first, uint end) {
  RegionFrame frame = region_frame[r];
  Vector n;
  n.x = frame.normal_x;
  n.y = frame.normal_y;
  n.z = frame.normal_z;
  Vector axis;
  axis.x = frame.axis_x;
  axis.y = frame.axis_y;
  axis.z = frame.axis_z;
  Vector around;
  around.x = frame.around_x;
  around.y = frame.around_y;
  around.z = frame.around_z;
  float bulge = bulge_of(n, first);
  float shear = shear_of(first);
  for (uint entry = first + 1u; entry < end; ++entry) {
    bulge += bulge_of(n, entry);
    shear += shear_of(entry);
  }
  return muscle_twist(muscle_scale(n, bulge), axis, around, shear);
}

void main() {
  uint r = item_index();
  if (r >= push.substep.vertex_count) return;
  Vector q = vector_of(position[r]);
  Vector q0 = vector_of(rest[r]);
  vec4 last = rotation[r];
  Quaternion turn;
  turn.w = last.x;
  turn.x = last.y;
  turn.y = last.z;
  turn.z = last.w;
  vec4 centre = region_rest[r];

  // Without neighbours or weight the sums are zero and the last rotation stays.
  RegionSum sum = no_terms();
  uint degree = ring_size(r);
  if (degree != 0u && centre.w > 0.0f) sum = sum_of_neighbours(r, degree, q, q0);

  Vector o = vector_of(centre);
  Matrix a = region_moment(sum, o);
  Matrix push_of_volume;
  if (with_volume) {
    vec4 record = region_volume[r];
    push_of_volume = volume_push(a, record.x, record.y, record.z);
  }
  bool scaled = false;
  Matrix t;
  if (with_muscles) {
    uint first = muscle_offset[r];
    uint end = muscle_offset[r + 1u];
    scaled = first < end;
    if (scaled) t = scale_of_muscles(r, first, end);
  }
  if (scaled) {
    a = multiply_transposed(a, t);
  }
  turn = extract_rotation(turn, a, rotation_method == rotation_mueller2016);
  Matrix linear = matrix_of(turn);
  if (scaled) linear = multiply_matrices(linear, t);
  if (with_volume) linear = add(linear, push_of_volume);
  rotation[r] = vec4(turn.w, turn.x, turn.y, turn.z);
  store_transform(r, region_transform(linear, sum, o, centre.w, q, q0));
}
