#include "host/model/model.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>

namespace fascicle::model {

std::vector<char> on_rigid_parts(const Model& model) {
  std::vector<std::uint32_t> parent(model.vertex_count);
  std::iota(parent.begin(), parent.end(), std::uint32_t{0});
  const auto root = [&parent](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (std::size_t k = 0; k < model.tetrahedron.size(); ++k)
    parent[root(model.tetrahedron[k])] = root(model.tetrahedron[k - k % 4]);
  std::vector<char> has_flesh(model.vertex_count, 0);  // at the root of each part
  bool has_any = false;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    if (!model.is_kinematic(i)) {
      has_flesh[root(i)] = 1;
      has_any = true;
    }
  std::vector<char> is_rigid(model.vertex_count, 0);
  for (std::uint32_t i = 0; has_any && i < model.vertex_count; ++i) is_rigid[i] = has_flesh[root(i)] == 0;
  return is_rigid;
}

double extent(const Model& model) {
  const std::vector<char> is_rigid = on_rigid_parts(model);
  std::array<float, 3> low{}, high{};
  bool is_first = true;
  for (std::size_t i = 0; i < model.vertex_count; ++i) {
    if (is_rigid[i] != 0) continue;
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
