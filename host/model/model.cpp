#include "host/model/model.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace fascicle::model {

const char* name_of(WeightForm form) {
  return form == WeightForm::symmetric ? "symmetric" : "kaneda2017";
}
const char* name_of(Integrator integrator) {
  return integrator == Integrator::explicit_step ? "explicit" : "implicit";
}
const char* name_of(Rotation rotation) {
  return rotation == Rotation::qcp ? "qcp" : "mueller2016";
}

namespace {

[[noreturn]] void broken(const char* array, std::size_t index, const std::string& promise) {
  std::ostringstream text;
  text << "model: " << array << "[" << index << "]: " << promise;
  throw std::invalid_argument(text.str());
}

template <class T>
void check_size(const char* array, const std::vector<T>& values, std::size_t size) {
  if (values.size() != size)
    broken(array, values.size(),
           "has " + std::to_string(values.size()) + " entries, must have " + std::to_string(size));
}

void check_finite(const char* array, const std::vector<float>& values) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i])) broken(array, i, "is not finite");
}

void check_range(const char* array, const std::vector<float>& values, float low, float high) {
  check_finite(array, values);
  for (std::size_t i = 0; i < values.size(); ++i)
    if (values[i] < low || values[i] > high)
      broken(array, i,
             "is " + std::to_string(values[i]) + ", must lie in [" + std::to_string(low) + ", " +
                 std::to_string(high) + "]");
}

// What no snap sees must not be small enough to make a product denormal.
void check_factors(const char* array, const std::vector<float>& values, float high) {
  check_range(array, values, 0.0f, high);
  for (std::size_t i = 0; i < values.size(); ++i)
    if (values[i] != 0.0f && values[i] < least_factor) broken(array, i, "is below 2^-40 and not 0");
}

void check_indices(const char* array, const std::vector<std::uint32_t>& values, std::uint32_t count) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (values[i] >= count)
      broken(array, i, "is " + std::to_string(values[i]) + ", must be below " + std::to_string(count));
}

void check_offsets(const char* array, const std::vector<std::uint32_t>& offsets, std::size_t count,
                   std::size_t entries) {
  check_size(array, offsets, count + 1);
  if (offsets.front() != 0) broken(array, 0, "must be 0");
  for (std::size_t i = 0; i < count; ++i)
    if (offsets[i + 1] < offsets[i]) broken(array, i + 1, "is below the entry before it");
  if (offsets.back() != entries)
    broken(array, count, "must be the number of entries, " + std::to_string(entries));
}

void check_one_rings(const Model& m) {
  const std::uint32_t n = m.vertex_count;
  check_offsets("ring_offset", m.ring_offset, n, m.ring.size());
  check_indices("ring", m.ring, n);
  check_size("share_taken", m.share_taken, m.ring.size());
  check_size("share_given", m.share_given, m.ring.size());
  check_range("share_taken", m.share_taken, 0.0f, 1.0f);
  check_range("share_given", m.share_given, 0.0f, 1.0f);
  for (std::uint32_t i = 0; i < n; ++i) {
    double given = 0.0;
    for (std::uint32_t e = m.ring_offset[i]; e < m.ring_offset[i + 1]; ++e) {
      const std::uint32_t j = m.ring[e];
      if (j == i) broken("ring", e, "holds the vertex itself");
      if (e > m.ring_offset[i] && m.ring[e - 1] >= j) broken("ring", e, "is not ascending");
      const auto first = m.ring.begin() + m.ring_offset[j], last = m.ring.begin() + m.ring_offset[j + 1];
      const auto back = std::lower_bound(first, last, i);
      if (back == last || *back != i) broken("ring", e, "has no entry the other way round");
      if (m.share_taken[static_cast<std::size_t>(back - m.ring.begin())] != m.share_given[e])
        broken("share_given", e, "differs from share_taken of the same pair");
      if (const float steps = m.share_given[e] * 65536.0f; steps != std::floor(steps))
        broken("share_given", e, "is not a multiple of 2^-16");
      given += static_cast<double>(m.share_given[e]);
    }
    if (given > 1.0)
      broken("share_given", m.ring_offset[i], "the shares of vertex " + std::to_string(i) + " exceed 1");
  }
}

void check_stiffness(const Model& m) {
  const auto check = [&](const char* array, const std::vector<double>& values) {
    if (values.size() != (m.stiffness.empty() ? 0 : m.vertex_count))
      broken(array, values.size(), "must have an entry a vertex, and stiffness too, or neither");
    for (std::size_t i = 0; i < values.size(); ++i)
      if (!(values[i] > 0.0) || !std::isfinite(values[i])) broken(array, i, "is not positive");
  };
  check("youngs_modulus", m.youngs_modulus);
  check("stiffness", m.stiffness);
  if (!m.is_implicit()) return;
  if (!m.momentum_scaled) broken("stiffness", 0, "the implicit integrator needs momentum-scaled weights");
  if (m.has_skeleton()) check_size("carried", m.carried, m.vertex_count);
}

void check_muscles(const Model& m) {
  if (m.muscle_count == 0) {
    check_size("muscle_offset", m.muscle_offset, 0);
    check_size("region_muscle", m.region_muscle, 0);
    check_size("region_frame", m.region_frame, 0);
    return;
  }
  check_offsets("muscle_offset", m.muscle_offset, m.vertex_count, m.region_muscle.size());
  check_size("region_frame", m.region_frame, m.vertex_count);
  const auto is_factor = [](float x) {
    return std::isfinite(x) && (x == 0.0f || std::abs(x) >= least_factor);
  };
  for (std::size_t k = 0; k < m.region_muscle.size(); ++k) {
    const shader::RegionMuscle& entry = m.region_muscle[k];
    if (entry.muscle >= m.muscle_count) broken("region_muscle", k, "names no muscle");
    if (!is_factor(entry.bulge) || !is_factor(entry.shear)) broken("region_muscle", k, "is no factor");
  }
  for (std::size_t r = 0; r < m.region_frame.size(); ++r) {
    const shader::RegionFrame& f = m.region_frame[r];
    for (const float x : {f.normal_x, f.normal_y, f.normal_z, f.axis_x, f.axis_y, f.axis_z, f.around_x,
                          f.around_y, f.around_z})
      if (!is_factor(x)) broken("region_frame", r, "has a number that is no factor");
  }
}

void check_volume(const Model& m) {
  if (m.volume_gain.empty() && m.region_volume.empty()) return;
  check_size("volume_gain", m.volume_gain, m.vertex_count);
  check_range("volume_gain", m.volume_gain, 0.0f, 1.0e3f);
  check_size("region_volume", m.region_volume, 3 * std::size_t{m.vertex_count});
  check_range("region_volume", m.region_volume, 0.0f, 3.0e38f);
  for (std::size_t r = 0; r < m.vertex_count; ++r)
    if (!(m.region_volume[3 * r + 1] >= least_factor))
      broken("region_volume", 3 * r + 1, "is a norm that is not positive");
}

void check_ties(const Model& m) {
  if (!m.has_ties()) {
    check_size("tie_offset", m.tie_offset, 0);
    check_size("tie_index", m.tie_index, 0);
    check_size("tie_coefficient", m.tie_coefficient, 0);
    return;
  }
  for (std::size_t k = 0; k < m.tie.size(); ++k) {
    const shader::Tie& t = m.tie[k];
    for (const std::uint32_t i : {t.sliding, t.corner_a, t.corner_b, t.corner_c})
      if (i >= m.vertex_count) broken("tie", k, "names no vertex");
    for (const std::uint32_t i : {t.corner_a, t.corner_b, t.corner_c})
      if (i == t.sliding) broken("tie", k, "ties a vertex to itself");
    for (const float mobility : {t.mobility_a, t.mobility_b, t.mobility_c})
      if (mobility != 0.0f && !(mobility >= least_factor && mobility <= 0x1p40f))
        broken("tie", k, "has a mobility that is out of its range");
    if (!(t.rest_height >= least_factor) || !std::isfinite(t.rest_height)) broken("tie", k, "has no height");
  }
  check_offsets("tie_offset", m.tie_offset, m.vertex_count, m.tie_index.size());
  check_indices("tie_index", m.tie_index, static_cast<std::uint32_t>(m.tie.size()));
  check_size("tie_coefficient", m.tie_coefficient, m.tie_index.size());
  for (std::uint32_t i = 0; i < m.vertex_count; ++i)
    for (std::uint32_t e = m.tie_offset[i]; e < m.tie_offset[i + 1]; ++e) {
      const shader::Tie& t = m.tie[m.tie_index[e]];
      if (m.is_kinematic(i)) broken("tie_index", e, "acts on a kinematic vertex");
      if (e > m.tie_offset[i] && m.tie_index[e - 1] >= m.tie_index[e])
        broken("tie_index", e, "is not ascending");
      if (i != t.sliding && i != t.corner_a && i != t.corner_b && i != t.corner_c)
        broken("tie_index", e, "is not a tie of this vertex");
      if (!(m.tie_coefficient[e] >= least_factor && m.tie_coefficient[e] <= 0x1p40f))
        broken("tie_coefficient", e, "is out of its range");
    }
}

void check_limits(const Model& m) {
  if (!m.has_limits()) {
    check_size("limit_offset", m.limit_offset, 0);
    check_size("limit_entry", m.limit_entry, 0);
    check_size("mobility", m.mobility, 0);
    return;
  }
  if (!m.is_implicit()) broken("limit", 0, "is for the implicit integrator");
  for (std::size_t k = 0; k < m.limit.size(); ++k) {
    const shader::Limit& t = m.limit[k];
    for (const std::uint32_t i : {t.corner_a, t.corner_b, t.corner_c, t.corner_d})
      if (i >= m.vertex_count) broken("limit", k, "names no vertex");
    if (!(t.size >= 0x1p-40f && t.size <= 2.0f && t.size * t.inverse_size == 1.0f))
      broken("limit", k, "has no size");
    for (const float number : {t.least, t.least_square})
      if (!(number >= least_factor && number <= 0x1p40f)) broken("limit", k, "has no rest shape");
  }
  check_offsets("limit_offset", m.limit_offset, m.vertex_count, m.limit_entry.size());
  check_size("limit_entry", m.limit_entry, 4 * m.limit.size());
  check_indices("limit_entry", m.limit_entry, static_cast<std::uint32_t>(4 * m.limit.size()));
  check_size("mobility", m.mobility, m.vertex_count);
  for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
    if (m.is_kinematic(i) ? m.mobility[i] != 0.0f
                          : !(m.mobility[i] >= least_factor && m.mobility[i] <= 0x1p40f))
      broken("mobility", i, "is out of its range");
    for (std::uint32_t e = m.limit_offset[i]; e < m.limit_offset[i + 1]; ++e) {
      const shader::Limit& t = m.limit[m.limit_entry[e] / 4];
      const std::array<std::uint32_t, 4> corners{t.corner_a, t.corner_b, t.corner_c, t.corner_d};
      if (corners[m.limit_entry[e] % 4] != i) broken("limit_entry", e, "is not a corner of this vertex");
      if (e > m.limit_offset[i] && m.limit_entry[e - 1] >= m.limit_entry[e])
        broken("limit_entry", e, "is not ascending");
    }
  }
}

void check_skin(const Model& m) {
  if (m.joint_count == 0) {
    check_size("skin_offset", m.skin_offset, 0);
    check_size("skin_joint", m.skin_joint, 0);
    check_size("skin_weight", m.skin_weight, 0);
    check_size("carried", m.carried, 0);
    return;
  }
  check_offsets("skin_offset", m.skin_offset, m.vertex_count, m.skin_joint.size());
  check_size("skin_weight", m.skin_weight, m.skin_joint.size());
  check_indices("skin_joint", m.skin_joint, m.joint_count);
  check_range("skin_weight", m.skin_weight, 0.0f, 1.0f);
  for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
    double sum = 0.0;
    for (std::uint32_t k = m.skin_offset[i]; k < m.skin_offset[i + 1]; ++k)
      sum += static_cast<double>(m.skin_weight[k]);
    // Each of up to 8 weights is rounded to float once: 8 half ULPs below 1.
    if (std::abs(sum - 1.0) > 8 * 0x1p-24) broken("skin_weight", m.skin_offset[i], "weights do not sum to 1");
  }
  if (m.carried.empty()) return;
  check_size("carried", m.carried, m.vertex_count);
  check_range("carried", m.carried, least_carried, 1.0f);
  for (std::size_t i = 0; i < m.carried.size(); ++i)
    if (m.carried[i] != 0.0f && std::abs(m.carried[i]) < least_factor)
      broken("carried", i, "is below 2^-40 in size and not 0");
}

void check_forces(const Model& m) {
  if (m.force_count == 0) {
    check_size("force_offset", m.force_offset, 0);
    check_size("force_index", m.force_index, 0);
    check_size("force_coefficient", m.force_coefficient, 0);
    return;
  }
  check_offsets("force_offset", m.force_offset, m.vertex_count, m.force_index.size());
  check_size("force_coefficient", m.force_coefficient, m.force_index.size());
  check_indices("force_index", m.force_index, m.force_count);
  check_finite("force_coefficient", m.force_coefficient);
}

}  // namespace

void check_model(const Model& m) {
  const std::size_t n = m.vertex_count;
  if (n == 0) broken("vertex_count", 0, "is 0");
  int exponent = 0;
  if (!(m.unit > 0.0) || std::frexp(m.unit, &exponent) != 0.5) broken("unit", 0, "is not a power of two");
  check_size("source_vertex", m.source_vertex, n);
  check_size("rest", m.rest, 3 * n);
  check_finite("rest", m.rest);
  check_size("mass", m.mass, n);
  for (std::size_t i = 0; i < n; ++i)
    if (!(m.mass[i] > 0.0) || !std::isfinite(m.mass[i])) broken("mass", i, "is not positive");
  check_size("alpha", m.alpha, n);
  // The explicit step is stable below 4; the paper's range is [0, 1].
  check_factors("alpha", m.alpha, 4.0f);
  check_size("beta", m.beta, n);
  check_range("beta", m.beta, 0.0f, 1.0f);
  check_size("fibre", m.fibre, 3 * n);
  check_finite("fibre", m.fibre);
  check_size("tag", m.tag, n);
  if (m.layers.empty() || m.layers.size() > shader::tag_layer_mask + 1)
    broken("layers", m.layers.size(), "there must be 1 to 256 layers");
  for (std::uint32_t i = 0; i < n; ++i)
    if (m.layer_of(i) >= m.layers.size()) broken("tag", i, "names no layer");
  check_one_rings(m);
  check_size("pull", m.pull, n);
  check_factors("pull", m.pull, 3.0e38f);
  check_size("region_rest", m.region_rest, 4 * n);
  check_finite("region_rest", m.region_rest);
  check_stiffness(m);
  check_muscles(m);
  check_volume(m);
  check_ties(m);
  check_limits(m);
  check_skin(m);
  check_forces(m);
  check_size("surface_weight", m.surface_weight, m.surface_vertex.size());
  if (m.surface_vertex.size() % 4 != 0)
    broken("surface_vertex", m.surface_vertex.size(), "is not four a vertex");
  check_indices("surface_vertex", m.surface_vertex, m.vertex_count);
  check_finite("surface_weight", m.surface_weight);
  if (m.surface_triangle.size() % 3 != 0)
    broken("surface_triangle", m.surface_triangle.size(), "is not three a triangle");
  check_indices("surface_triangle", m.surface_triangle, m.surface_count());
  if (m.tetrahedron.size() % 4 != 0) broken("tetrahedron", m.tetrahedron.size(), "is not four a tetrahedron");
  check_indices("tetrahedron", m.tetrahedron, m.vertex_count);
  for (const ProbeSet& probe : m.probes) check_indices("probes", probe.vertices, m.vertex_count);
}

std::uint64_t solver_bytes(const Model& m) {
  const auto bytes = [](const auto& array) { return std::uint64_t{array.size()} * sizeof(array[0]); };
  const std::uint64_t n = m.vertex_count;
  const std::uint64_t fixed =
      bytes(m.rest) + bytes(m.alpha) + bytes(m.tag) + bytes(m.ring_offset) + bytes(m.ring) + bytes(m.pull) +
      bytes(m.share_taken) + bytes(m.share_given) + bytes(m.region_rest) + bytes(m.muscle_offset) +
      bytes(m.region_muscle) + bytes(m.region_frame) + bytes(m.region_volume) + bytes(m.tie) +
      bytes(m.tie_offset) + bytes(m.tie_index) + bytes(m.tie_coefficient) + bytes(m.limit) +
      bytes(m.limit_offset) + bytes(m.limit_entry) + bytes(m.mobility) + bytes(m.skin_offset) +
      bytes(m.skin_joint) + bytes(m.skin_weight) + bytes(m.carried) + bytes(m.force_offset) +
      bytes(m.force_index) + bytes(m.force_coefficient) + bytes(m.surface_vertex) + bytes(m.surface_weight);
  const std::uint64_t floats_of_state = 3 + 3 + 4 + 12 + (m.has_skeleton() ? 9 : 0) +
                                        (m.carried.empty() ? 0 : 3) + (m.has_ties() ? 3 : 0) +
                                        (m.is_implicit() ? 3 + 3 + 3 + 3 + 8 : 0);
  const std::uint64_t of_limits = (m.limit.size() + m.mobility.size()) * sizeof(float);
  return fixed + of_limits + n * floats_of_state * sizeof(float) +
         std::uint64_t{m.surface_count()} * 3 * sizeof(float);
}

double extent(const Model& model) {
  float largest = 0.0f;
  for (std::size_t axis = 0; axis < 3 && !model.rest.empty(); ++axis) {
    float low = model.rest[axis], high = low;
    for (std::size_t k = axis; k < model.rest.size(); k += 3) {
      low = std::min(low, model.rest[k]);
      high = std::max(high, model.rest[k]);
    }
    largest = std::max(largest, high - low);
  }
  return double{largest} * model.unit;
}

}  // namespace fascicle::model
