// A tree of bounding boxes over triangles, tetrahedra or points. It finds what lies near a point or on a ray
// without visiting everything. Deterministic: built with + - * / and comparisons only; ties are broken by
// item number.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace fascicle::build {

struct BoundingBox {
  Eigen::Vector3d low, high;
};

// The smallest box around at least one point.
template <class Points>
BoundingBox box_around(const Points& points) {
  BoundingBox box{*std::begin(points), *std::begin(points)};
  for (const Eigen::Vector3d& p : points) {
    box.low = box.low.cwiseMin(p);
    box.high = box.high.cwiseMax(p);
  }
  return box;
}

// Square of the distance from a point to a box, 0 inside.
inline double squared_distance(const BoundingBox& box, const Eigen::Vector3d& point) {
  double sum = 0.0;
  for (int a = 0; a < 3; ++a) {
    const double outside = std::max({box.low[a] - point[a], point[a] - box.high[a], 0.0});
    sum += outside * outside;
  }
  return sum;
}

class BoxTree {
 public:
  // Box coordinates must be finite; item k is boxes[k]. The span may be empty.
  explicit BoxTree(std::span<const BoundingBox> boxes);

  // Calls visit(item) for every item whose box is within sqrt(`bound2`) of `point`, the nearer half of each
  // node first. visit returns the new bound, which must not grow. If it returns the squared distance to the
  // best item so far, the search finds the nearest item.
  template <class Visit>
  void visit_near(const Eigen::Vector3d& point, double bound2, Visit visit) const {
    if (nodes_.empty()) return;
    struct Waiting {
      std::uint32_t node;
      double distance2;
    };
    std::array<Waiting, stack_size> stack;
    std::size_t top = 0;
    stack[top++] = {0, squared_distance(nodes_[0].box, point)};
    while (top > 0) {
      const Waiting next = stack[--top];
      if (next.distance2 > bound2) continue;
      const Node& node = nodes_[next.node];
      if (node.count > 0) {
        for (std::uint32_t k = 0; k < node.count; ++k) bound2 = visit(items_[node.first + k]);
        continue;
      }
      Waiting nearer{next.node + 1, squared_distance(nodes_[next.node + 1].box, point)};
      Waiting farther{node.first, squared_distance(nodes_[node.first].box, point)};
      if (farther.distance2 < nearer.distance2) std::swap(nearer, farther);
      stack[top++] = farther;
      stack[top++] = nearer;
    }
  }

  // Calls visit(item) for every item whose box meets the ray from `origin` along `direction`. No component of
  // the direction may be 0.
  template <class Visit>
  void visit_ray(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, Visit visit) const {
    if (nodes_.empty()) return;
    const Eigen::Vector3d inverse = direction.cwiseInverse();
    std::array<std::uint32_t, stack_size> stack;
    std::size_t top = 0;
    stack[top++] = 0;
    while (top > 0) {
      const std::uint32_t index = stack[--top];
      const Node& node = nodes_[index];
      if (!meets(node.box, origin, inverse)) continue;
      if (node.count > 0) {
        for (std::uint32_t k = 0; k < node.count; ++k) visit(items_[node.first + k]);
        continue;
      }
      stack[top++] = node.first;
      stack[top++] = index + 1;
    }
  }

 private:
  // An inner node's first child follows it, `first` is the second child; a leaf has `count` items from
  // `first`.
  struct Node {
    BoundingBox box;
    std::uint32_t first = 0;
    std::uint32_t count = 0;
  };
  // Nodes are halved by count, so the depth is at most 32, and each level leaves one pending node.
  static constexpr std::size_t stack_size = 64;

  static bool meets(const BoundingBox& box, const Eigen::Vector3d& origin, const Eigen::Vector3d& inverse);
  std::uint32_t add_node(std::span<const BoundingBox> boxes, std::span<const Eigen::Vector3d> centres,
                         std::uint32_t begin, std::uint32_t end);

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> items_;
};

}  // namespace fascicle::build
