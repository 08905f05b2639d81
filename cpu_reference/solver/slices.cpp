#include "cpu_reference/solver/slices.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace fascicle::cpu_reference {

namespace {

using model::Model;

constexpr float one_share = 0x1p-16f;

bool fits_parts(float share) {
  const float parts = share / one_share;
  return parts >= 0.0f && parts <= 65535.0f && parts == static_cast<float>(static_cast<std::uint16_t>(parts));
}

std::int64_t difference(const Model& model, std::uint32_t i, std::uint32_t entry) {
  return std::int64_t{model.ring[entry]} - std::int64_t{i / slice_size * slice_size};
}

bool can_be_compact(const Model& model) {
  using Near = std::numeric_limits<std::int16_t>;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    for (std::uint32_t e = model.ring_offset[i]; e < model.ring_offset[i + 1]; ++e) {
      const std::int64_t d = difference(model, i, e);
      if (d < Near::min() || d > Near::max()) return false;
      if (!fits_parts(model.share_taken[e]) || !fits_parts(model.share_given[e])) return false;
    }
  return !model.ring.empty();
}

std::vector<std::uint32_t> reach_of_slices(const Model& model, std::uint32_t slices) {
  std::vector<std::uint32_t> reach(slices + slices_ahead, 0);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    std::uint32_t& last = reach[i / slice_size];
    last = std::max(last, i + 1);
    for (std::uint32_t e = model.ring_offset[i]; e < model.ring_offset[i + 1]; ++e)
      last = std::max(last, model.ring[e] + 1);
  }
  std::inclusive_scan(reach.begin(), reach.end(), reach.begin(),
                      [](std::uint32_t a, std::uint32_t b) { return std::max(a, b); });
  return reach;
}

std::uint32_t end_of(const Model& model, std::uint32_t slice) {
  return std::min(model.vertex_count, (slice + 1) * slice_size);
}

bool is_held(const Model& model, std::uint32_t slice) {
  for (std::uint32_t i = slice * slice_size; i < end_of(model, slice); ++i)
    if (!model.is_kinematic(i)) return false;
  return true;
}

std::uint32_t layer_of_all(const Model& model, std::uint32_t slice) {
  const std::uint32_t layer = model.layer_of(slice * slice_size);
  for (std::uint32_t i = slice * slice_size; i < end_of(model, slice); ++i)
    if (model.layer_of(i) != layer) return several_layers;
  return layer;
}

}  // namespace

Slices make_slices(const Model& model, LineAllocator<float> memory) {
  const std::uint32_t n = model.vertex_count;
  Slices slices(memory);
  slices.count = slice_count(n);
  slices.taken_degree.assign(std::size_t{slices.count} * slice_size, 0);
  slices.degree.assign(std::size_t{slices.count} * slice_size, 0);
  slices.first_row.push_back(0);
  slices.reach = reach_of_slices(model, slices.count);
  for (std::uint32_t s = 0; s < slices.count; ++s) {
    std::uint32_t rows = 0;
    auto full = std::numeric_limits<std::uint32_t>::max();
    for (std::uint32_t i = s * slice_size; i < (s + 1) * slice_size; ++i) {
      const std::uint32_t degree = i < n ? model.ring_offset[i + 1] - model.ring_offset[i] : 0;
      const std::uint32_t taken = i < n && model.region_rest[4 * std::size_t{i} + 3] > 0.0f ? degree : 0;
      slices.degree[i] = degree;
      slices.taken_degree[i] = static_cast<std::int32_t>(taken);
      rows = std::max(rows, degree);
      full = std::min(full, taken);
    }
    slices.full_rows.push_back(full);
    slices.is_held.push_back(is_held(model, s) ? 1 : 0);
    slices.layer.push_back(layer_of_all(model, s));
    slices.first_row.push_back(slices.first_row.back() + rows);
  }

  const std::size_t entries = std::size_t{slices.first_row.back()} * slice_size;
  const bool compact = can_be_compact(model);
  if (compact) {
    slices.near_ring.resize(entries);
    slices.taken_parts.resize(entries);
    slices.given_parts.resize(entries);
  } else {
    slices.far_ring.resize(entries);
    slices.taken.resize(entries);
    slices.given.resize(entries);
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    std::size_t at = std::size_t{slices.first_row[i / slice_size]} * slice_size + i % slice_size;
    for (std::uint32_t e = model.ring_offset[i]; e < model.ring_offset[i + 1]; ++e, at += slice_size) {
      if (compact) {
        slices.near_ring[at] = static_cast<std::int16_t>(difference(model, i, e));
        slices.taken_parts[at] = static_cast<std::uint16_t>(model.share_taken[e] / one_share);
        slices.given_parts[at] = static_cast<std::uint16_t>(model.share_given[e] / one_share);
      } else {
        slices.far_ring[at] = static_cast<std::int32_t>(difference(model, i, e));
        slices.taken[at] = model.share_taken[e];
        slices.given[at] = model.share_given[e];
      }
    }
  }
  return slices;
}

double substep_bytes(const Model& model, std::uint32_t passes) {
  const Slices slices = make_slices(model);
  const double vertex = sizeof(float) * vertex_stride, region = sizeof(float) * region_stride;
  const double vector = sizeof(float) * vector_stride, number = sizeof(std::uint32_t);
  const double entries = double{slice_size} * slices.first_row.back() / model.vertex_count;
  // An entry's neighbour and its share.
  const double entry = slices.is_compact() ? 4.0 : 8.0;
  const double regions = vertex + entries * entry + 4 * number + 2 * region;
  // Maps, neighbours and degree, tag; position, read and written.
  const double blend = region + entries * entry + 2 * number + 2 * vertex;
  if (!model.is_implicit()) return regions + blend + 2 * vector;
  // y, the previous iterate, the goal, the response.
  return passes * (regions + blend + vector + 2 * vector + vector + sizeof(shader::Response));
}

void fill_constants(const Model& model, const Slices& slices, Fields& fields) {
  const float scale = slices.is_compact() ? one_share : 1.0f;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    float* vertex = fields.vertices.data() + vertex_stride * i;
    vertex[pull_place] = model.pull[i] * scale;
    for (std::size_t c = 0; c < 3; ++c) vertex[rest_place + c] = model.rest[3 * std::size_t{i} + c];
    vertex[alpha_place] = model.alpha[i];
  }
}

}  // namespace fascicle::cpu_reference
