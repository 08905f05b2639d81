#include "host/model/model.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "host/model/surroundings.h"

namespace fascicle::model {

double extent(const Model& model) {
  const std::vector<char> is_beside = surroundings_of(model).vertices;
  std::array<float, 3> low{}, high{};
  bool is_first = true;
  for (std::size_t i = 0; i < model.vertex_count; ++i) {
    if (is_beside[i] != 0) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float place = model.rest[3 * i + axis];
      low[axis] = is_first ? place : std::min(low[axis], place);
      high[axis] = is_first ? place : std::max(high[axis], place);
    }
    is_first = false;
  }
  float largest = 0.0f;
  for (std::size_t axis = 0; axis < 3; ++axis) largest = std::max(largest, high[axis] - low[axis]);
  return double{largest} * model.unit;
}

std::vector<double> extents(const Model& model, std::span<const std::uint32_t> first_joint) {
  if (first_joint.size() < 2 || !model.has_skeleton()) return {extent(model)};
  std::vector<std::array<float, 3>> low(first_joint.size(), {1e30f, 1e30f, 1e30f}),
      high(first_joint.size(), {-1e30f, -1e30f, -1e30f});
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    const std::uint32_t joint = model.skin_joint[model.skin_offset[i]];
    std::size_t g = 0;
    while (g + 1 < first_joint.size() && first_joint[g + 1] <= joint) ++g;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[g][axis] = std::min(low[g][axis], model.rest[3 * std::size_t{i} + axis]);
      high[g][axis] = std::max(high[g][axis], model.rest[3 * std::size_t{i} + axis]);
    }
  }
  std::vector<double> all;
  for (std::size_t g = 0; g < low.size(); ++g) {
    float largest = 0.0f;
    for (std::size_t axis = 0; axis < 3; ++axis) largest = std::max(largest, high[g][axis] - low[g][axis]);
    all.push_back(double{largest} * model.unit);
  }
  return all;
}

}  // namespace fascicle::model
