#include "host/build/box_tree.h"

#include <limits>
#include <numeric>

namespace fascicle::build {

namespace {

using Eigen::Vector3d;

constexpr std::uint32_t leaf_items = 4;
// Rounding in the slab test must not let a ray miss a box that its triangle fills to the rim.
constexpr double ray_slack = 1e-12;

}  // namespace

BoxTree::BoxTree(std::span<const BoundingBox> boxes) : items_(boxes.size()) {
  if (boxes.empty()) return;
  std::iota(items_.begin(), items_.end(), 0u);
  std::vector<Vector3d> centres(boxes.size());
  for (std::size_t k = 0; k < boxes.size(); ++k) centres[k] = 0.5 * (boxes[k].low + boxes[k].high);
  nodes_.reserve(boxes.size());
  add_node(boxes, centres, 0, static_cast<std::uint32_t>(boxes.size()));
}

std::uint32_t BoxTree::add_node(std::span<const BoundingBox> boxes, std::span<const Vector3d> centres,
                                std::uint32_t begin, std::uint32_t end) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  Node node;
  node.box = boxes[items_[begin]];
  BoundingBox middle{centres[items_[begin]], centres[items_[begin]]};
  for (std::uint32_t k = begin; k < end; ++k) {
    node.box.low = node.box.low.cwiseMin(boxes[items_[k]].low);
    node.box.high = node.box.high.cwiseMax(boxes[items_[k]].high);
    middle.low = middle.low.cwiseMin(centres[items_[k]]);
    middle.high = middle.high.cwiseMax(centres[items_[k]]);
  }
  const auto items = items_.begin();
  if (end - begin <= leaf_items) {
    // The order below determines which items a leaf holds; the order in which nth_element leaves them is
    // unspecified.
    std::sort(items + begin, items + end);
    node.first = begin;
    node.count = end - begin;
    nodes_.push_back(node);
    return index;
  }
  nodes_.push_back(node);
  int axis = 0;
  (middle.high - middle.low).maxCoeff(&axis);
  const std::uint32_t half = begin + (end - begin) / 2;
  std::nth_element(items + begin, items + half, items + end, [&](std::uint32_t a, std::uint32_t b) {
    return centres[a][axis] != centres[b][axis] ? centres[a][axis] < centres[b][axis] : a < b;
  });
  add_node(boxes, centres, begin, half);
  const std::uint32_t second = add_node(boxes, centres, half, end);
  nodes_[index].first = second;
  return index;
}

bool BoxTree::meets(const BoundingBox& box, const Vector3d& origin, const Vector3d& inverse) {
  double enter = 0.0, leave = std::numeric_limits<double>::infinity();
  for (int a = 0; a < 3; ++a) {
    const double to_low = (box.low[a] - origin[a]) * inverse[a];
    const double to_high = (box.high[a] - origin[a]) * inverse[a];
    enter = std::max(enter, std::min(to_low, to_high));
    leave = std::min(leave, std::max(to_low, to_high));
  }
  return enter <= leave + ray_slack * (enter + std::abs(leave));
}

}  // namespace fascicle::build
