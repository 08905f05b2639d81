// check_model and solver_bytes: checks that follow from the table of arrays, then checks across arrays.
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <sstream>
#include <stdexcept>

#include "host/model/model_arrays.h"
#include "host/model/reach.h"

namespace fascicle::model {

namespace {

// Joints, muscles or forces: solvers have memory for as many as the model names.
constexpr std::uint32_t most_driven = std::uint32_t{1} << 20u;

[[noreturn]] void broken(const char* array, std::size_t index, const std::string& promise) {
  std::ostringstream text;
  text << "model: " << array << "[" << index << "]: " << promise;
  throw std::invalid_argument(text.str());
}

void check_size(const Model& m, const char* array, const ArrayTraits& traits, std::size_t size) {
  const auto must_have = [&](std::size_t wanted) {
    if (size != wanted)
      broken(array, size, "has " + std::to_string(size) + " entries, must have " + std::to_string(wanted));
  };
  const Items& items = traits.items;
  if (traits.is_there && !traits.is_there(m)) return must_have(0);
  if (traits.may_lack && size == 0) return;
  if (items.count) return must_have(items.each * items.count(m) + items.more);
  if (size % items.each != 0)
    broken(
        array, size,
        "has " + std::to_string(size) + " entries, which is not a multiple of " + std::to_string(items.each));
}

template <class Number>
void check_numbers(const char* array, const Values& promised, const std::vector<Number>& values) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Number x = values[i];
    if (!std::isfinite(x)) broken(array, i, "is not finite");
    if (promised.promise == Promise::finite) continue;
    if (promised.promise == Promise::positive) {
      if (!(x > 0)) broken(array, i, "is not positive");
      continue;
    }
    const Number low = promised.low, high = promised.high;
    if (x < low || x > high)
      broken(array, i,
             "is " + std::to_string(x) + ", must lie in [" + std::to_string(low) + ", " +
                 std::to_string(high) + "]");
    // Values that are not snapped to zero must not be so small that a product is denormal.
    if (promised.promise == Promise::factor && x != 0 && x < Number{least_factor})
      broken(array, i, "is below 2^-40 and not 0");
  }
}

void check_indices(const char* array, const std::vector<std::uint32_t>& values, std::size_t count) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (values[i] >= count)
      broken(array, i, "is " + std::to_string(values[i]) + ", must be below " + std::to_string(count));
}

void check_offsets(const char* array, const std::vector<std::uint32_t>& offsets, std::size_t entries) {
  if (offsets.empty()) return;
  if (offsets.front() != 0) broken(array, 0, "must be 0");
  for (std::size_t i = 0; i + 1 < offsets.size(); ++i)
    if (offsets[i + 1] < offsets[i]) broken(array, i + 1, "is below the entry before it");
  if (offsets.back() != entries)
    broken(array, offsets.size() - 1, "must be the number of entries, " + std::to_string(entries));
}

template <class T>
void check_values(const Model& m, const ArrayRow<T>& row, const std::vector<T>& values) {
  const Values& promised = row.traits.values;
  const std::size_t count = promised.count ? promised.each * promised.count(m) : 0;
  if constexpr (std::is_floating_point_v<T>) {
    if (promised.promise != Promise::none) check_numbers(row.name, promised, values);
  } else if constexpr (std::is_same_v<T, std::uint32_t>) {
    if (promised.promise == Promise::index) check_indices(row.name, values, count);
    if (promised.promise == Promise::offsets) check_offsets(row.name, values, count);
  }
}

// Number promises need arrays of numbers; index and offset promises need arrays of indices.
template <class T>
constexpr bool can_promise(const ArrayRow<T>& row) {
  const Promise promise = row.traits.values.promise;
  if (promise == Promise::none) return true;
  const bool of_indices = promise == Promise::index || promise == Promise::offsets;
  return of_indices ? std::is_same_v<T, std::uint32_t> : std::is_floating_point_v<T>;
}
static_assert(
    [] {
      bool all = true;
      base::for_each_row(model_arrays, [&](const auto& row) {
        if constexpr (is_array_row<std::decay_t<decltype(row)>>) all = all && can_promise(row);
      });
      return all;
    }(),
    "a row of model_arrays promises what its array's type cannot keep");

void check_one_rings(const Model& m) {
  for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
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

void check_implicit(const Model& m) {
  if (!m.is_implicit()) return;
  if (!m.momentum_scaled) broken("stiffness", 0, "the implicit integrator needs momentum-scaled weights");
  if (m.has_skeleton() && m.carried.empty()) broken("carried", 0, "an implicit model with a skeleton has it");
}

void check_muscles(const Model& m) {
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
  for (std::size_t at = 1; at < m.region_volume.size(); at += 3)
    if (!(m.region_volume[at] >= least_factor)) broken("region_volume", at, "is a norm that is not positive");
}

void check_ties(const Model& m) {
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
  for (std::uint32_t i = 0; m.has_ties() && i < m.vertex_count; ++i)
    for (std::uint32_t e = m.tie_offset[i]; e < m.tie_offset[i + 1]; ++e) {
      const shader::Tie& t = m.tie[m.tie_index[e]];
      if (m.is_kinematic(i)) broken("tie_index", e, "acts on a kinematic vertex");
      if (e > m.tie_offset[i] && m.tie_index[e - 1] >= m.tie_index[e])
        broken("tie_index", e, "is not ascending");
      if (i != t.sliding && i != t.corner_a && i != t.corner_b && i != t.corner_c)
        broken("tie_index", e, "is not a tie of this vertex");
    }
}

void check_limits(const Model& m) {
  if (!m.has_limits()) return;
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
  for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
    for (std::uint32_t e = m.limit_offset[i]; e < m.limit_offset[i + 1]; ++e) {
      const shader::Limit& t = m.limit[m.limit_entry[e] / 4];
      const std::array<std::uint32_t, 4> corners{t.corner_a, t.corner_b, t.corner_c, t.corner_d};
      if (corners[m.limit_entry[e] % 4] != i) broken("limit_entry", e, "is not a corner of this vertex");
      if (e > m.limit_offset[i] && m.limit_entry[e - 1] >= m.limit_entry[e])
        broken("limit_entry", e, "is not ascending");
    }
  }
}

void check_mobility(const Model& m) {
  for (std::uint32_t i = 0; i < m.mobility.size(); ++i)
    if (m.is_kinematic(i) != (m.mobility[i] == 0.0f))
      broken("mobility", i, "is 0 of kinematic vertices alone");
}

void check_contact_points(const Model& m) {
  std::uint32_t first_near = 0;
  for (std::uint32_t p = 0; p < m.contact.size(); ++p) {
    const shader::ContactPoint& point = m.contact[p];
    if (point.vertex >= m.vertex_count || m.contact_number[point.vertex] != p)
      broken("contact", p, "is not its vertex's point");
    if (p > 0 && m.contact[p - 1].vertex >= point.vertex) broken("contact", p, "is not ascending");
    for (const float number : {point.margin, point.allowance, point.friction})
      if (!(number == 0.0f || (number >= least_factor && number <= 0x1p20f)))
        broken("contact", p, "has a number that is out of its range");
    if (!(point.margin > 0.0f)) broken("contact", p, "has no margin");
    if (point.first_near != first_near || point.near_count > m.contact_near.size() - first_near)
      broken("contact", p, "does not go on in contact_near");
    for (std::uint32_t k = first_near; k < first_near + point.near_count; ++k) {
      const shader::VertexRun run = m.contact_near[k];
      if (run.first >= run.end || run.end > m.vertex_count) broken("contact_near", k, "holds no vertices");
      if (k > first_near && m.contact_near[k - 1].end >= run.first)
        broken("contact_near", k, "is not ascending and apart");
    }
    first_near += point.near_count;
  }
  if (first_near != m.contact_near.size()) broken("contact_near", first_near, "is no point's");
  std::size_t points = 0;
  for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
    if (m.contact_number[i] == shader::no_contact) continue;
    if (m.contact_number[i] >= m.contact.size()) broken("contact_number", i, "names no point");
    ++points;
  }
  if (points != m.contact.size()) broken("contact_number", 0, "names a point twice");
}

// The plain search may skip what lies outside a box; no other search would, so results would differ.
void check_contact_boxes(const Model& m) {
  const auto must_hold = [&](std::size_t box, const float* low, const float* high) {
    for (std::size_t a = 0; a < 3; ++a)
      if (!(m.contact_rest_box[8 * box + a] <= low[a] && high[a] <= m.contact_rest_box[8 * box + 4 + a]))
        broken("contact_rest_box", 8 * box + a, "leaves out some of what it is around");
  };
  for (std::size_t e = 0; e < m.contact_tetrahedron.size(); ++e) {
    const float* x = m.rest.data() + 3 * std::size_t{m.contact_tetrahedron[e]};
    must_hold(e / 4 / shader::contact_leaf, x, x);
  }
  for (std::size_t leaf = 0; leaf < m.contact_leaf_count(); ++leaf) {
    const float* box = m.contact_rest_box.data() + 8 * leaf;
    must_hold(m.contact_leaf_count() + leaf / shader::contact_branch, box, box + 4);
  }
}

void check_ignored_contact(const Model& m) {
  std::uint32_t groups = 0;
  for (const std::uint32_t of_tetrahedron : m.contact_group) groups |= of_tetrahedron;
  for (std::size_t p = 0; p < m.contact_ignored.size(); ++p) {
    if ((m.contact_ignored[p] & ~groups) != 0)
      broken("contact_ignored", p, "names a group that no tetrahedron is of");
  }
}

void check_contact(const Model& m) {
  if (!m.has_contact()) return;
  if (m.contact_tetrahedron_count() >= shader::no_contact / 4)
    broken("contact_tetrahedron", m.contact_tetrahedron.size(), "are too many");
  check_contact_points(m);
  for (std::uint32_t i = 0; i < m.vertex_count; ++i)
    for (std::uint32_t e = m.contact_offset[i]; e < m.contact_offset[i + 1]; ++e) {
      if (m.contact_tetrahedron[m.contact_entry[e]] != i)
        broken("contact_entry", e, "is not a corner of this vertex");
      if (e > m.contact_offset[i] && m.contact_entry[e - 1] >= m.contact_entry[e])
        broken("contact_entry", e, "is not ascending");
    }
  check_contact_boxes(m);
  check_ignored_contact(m);
}

void check_skin(const Model& m) {
  for (std::uint32_t i = 0; m.has_skeleton() && i < m.vertex_count; ++i) {
    double sum = 0.0;
    for (std::uint32_t k = m.skin_offset[i]; k < m.skin_offset[i + 1]; ++k)
      sum += static_cast<double>(m.skin_weight[k]);
    // Each of up to 8 weights is rounded to float once: 8 half ULPs below 1.
    if (std::abs(sum - 1.0) > 8 * 0x1p-24) broken("skin_weight", m.skin_offset[i], "weights do not sum to 1");
  }
  for (std::size_t i = 0; i < m.carried.size(); ++i)
    if (m.carried[i] != 0.0f && std::abs(m.carried[i]) < least_factor)
      broken("carried", i, "is below 2^-40 in size and not 0");
}

}  // namespace

void check_model(const Model& m) {
  if (m.vertex_count == 0) broken("vertex_count", 0, "is 0");
  for (const auto& [name, count] :
       {std::pair("joint_count", m.joint_count), std::pair("muscle_count", m.muscle_count),
        std::pair("force_count", m.force_count)})
    if (count > most_driven)
      broken(name, 0, "is " + std::to_string(count) + ", must be at most " + std::to_string(most_driven));
  int exponent = 0;
  if (!(m.unit > 0.0) || std::frexp(m.unit, &exponent) != 0.5) broken("unit", 0, "is not a power of two");
  if (m.unit > farthest) broken("unit", 0, "is longer than any body");
  for (std::size_t a = 0; a < m.rest_origin.size(); ++a)
    if (!is_in_reach({m.rest_origin[a], 0.0, 0.0}))
      broken("rest_origin", a, "is not finite, or too far away");
  for (std::size_t k = 0; k < m.rest.size(); ++k)
    if (!is_in_reach(std::span(&m.rest[k], 1), m.unit)) broken("rest", k, "is not finite, or too far away");
  for_each_array(
      m, [&](const auto& row, const auto& values) { check_size(m, row.name, row.traits, values.size()); });
  // Sizes are right: offsets and indices may be followed from here on.
  for_each_array(m, [&](const auto& row, const auto& values) { check_values(m, row, values); });
  if (m.collider_count > most_colliders)
    broken("collider_count", 0,
           "is " + std::to_string(m.collider_count) + ", must be at most " + std::to_string(most_colliders));
  if (m.layers.empty() || m.layers.size() > shader::tag_layer_mask + 1)
    broken("layers", m.layers.size(), "there must be 1 to 256 layers");
  for (std::size_t k = 0; k < m.layers.size(); ++k)
    if (!std::isfinite(m.layers[k].damping) || m.layers[k].damping < 0.0)
      broken("layer.damping", k, "is not a finite number of at least 0");
  for (std::uint32_t i = 0; i < m.vertex_count; ++i)
    if (m.layer_of(i) >= m.layers.size()) broken("tag", i, "names no layer");
  for (const ProbeSet& probe : m.probes) check_indices("probes", probe.vertices, m.vertex_count);
  check_one_rings(m);
  check_implicit(m);
  check_muscles(m);
  check_volume(m);
  check_ties(m);
  check_limits(m);
  check_mobility(m);
  check_contact(m);
  check_skin(m);
}

std::uint64_t solver_bytes(const Model& m) {
  std::uint64_t arrays = 0;
  for_each_array(m, [&](const auto& row, const auto& values) {
    if (row.traits.needed == Needed::by_solvers) arrays += std::uint64_t{values.size()} * sizeof(values[0]);
  });
  const std::uint64_t n = m.vertex_count;
  const std::uint64_t floats_of_state = 3 + 3 + 4 + 12 + (m.has_skeleton() ? 9 : 0) +
                                        (m.carried.empty() ? 0 : 3) + (m.has_ties() ? 3 : 0) +
                                        (m.is_implicit() ? 3 + 3 + 3 + 3 + 8 : 0);
  const std::uint64_t of_limits = m.has_limits() ? m.limit.size() + n : 0;
  // Per point: tetrahedron found, next in chain, weights, push and normal, impulse. Per vertex: crowd and
  // acceleration. Boxes. Per tetrahedron: start of its chain.
  const std::uint64_t of_contact =
      m.has_contact() ? m.contact.size() * (1 + 1 + 4 + 3 + 3 + 3) + n * (1 + 3) +
                            (std::uint64_t{m.contact_leaf_count()} + m.contact_branch_count()) * 6 +
                            m.contact_tetrahedron_count()
                      : 0;
  return arrays + (of_limits + of_contact + n * floats_of_state + std::uint64_t{m.surface_count()} * 3) *
                      sizeof(float);
}

}  // namespace fascicle::model
