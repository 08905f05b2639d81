// Vertices that are near a point of contact across a gap: Model::contact_near. Vertices near each other have
// similar numbers, so runs take a fifth of the memory of single numbers.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "host/model/model.h"

namespace fascicle::model {

inline std::span<const shader::VertexRun> near_runs(const Model& model, const shader::ContactPoint& point) {
  return std::span(model.contact_near).subspan(point.first_near, point.near_count);
}

inline bool is_across_a_gap(const Model& model, const shader::ContactPoint& point, std::uint32_t vertex) {
  const std::span<const shader::VertexRun> runs = near_runs(model, point);
  const auto run = std::upper_bound(runs.begin(), runs.end(), vertex,
                                    [](std::uint32_t i, const shader::VertexRun& of) { return i < of.end; });
  return run != runs.end() && run->first <= vertex;
}

// Appends ascending vertices to `runs` as runs.
inline void append_runs(std::span<const std::uint32_t> vertices, std::vector<shader::VertexRun>& runs) {
  const std::size_t before = runs.size();
  for (const std::uint32_t i : vertices) {
    if (runs.size() > before && runs.back().end == i)
      ++runs.back().end;
    else
      runs.push_back({i, i + 1});
  }
}

}  // namespace fascicle::model
