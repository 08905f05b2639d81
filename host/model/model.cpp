#include "host/model/model.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace fascicle::model {

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
