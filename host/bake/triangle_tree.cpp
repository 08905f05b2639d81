#include "host/bake/triangle_tree.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "host/bake/points.h"

namespace fascicle::bake {

namespace {

constexpr std::uint32_t leaf_triangles = 4;

// Whether the edge from p to q passes through the interior of the triangle a b c. `p_side` and `q_side` are
// their heights above its plane.
bool pierces(const Point& p, const Point& q, double p_side, double q_side, const Point& a, const Point& b,
             const Point& c) {
  if (!((p_side > 0.0 && q_side < 0.0) || (p_side < 0.0 && q_side > 0.0))) return false;
  const Point way = difference(q, p);
  const Point pa = difference(a, p), pb = difference(b, p), pc = difference(c, p);
  const double ab = dot(way, cross_product(pa, pb));
  const double bc = dot(way, cross_product(pb, pc));
  const double ca = dot(way, cross_product(pc, pa));
  return (ab > 0.0 && bc > 0.0 && ca > 0.0) || (ab < 0.0 && bc < 0.0 && ca < 0.0);
}

// Heights of the corners of one triangle above the plane of another.
Point heights(const std::array<Point, 3>& of, const std::array<Point, 3>& over) {
  const Point normal = cross_product(difference(over[1], over[0]), difference(over[2], over[0]));
  return {dot(normal, difference(of[0], over[0])), dot(normal, difference(of[1], over[0])),
          dot(normal, difference(of[2], over[0]))};
}

bool on_one_side(const Point& h) {
  return (h[0] >= 0.0 && h[1] >= 0.0 && h[2] >= 0.0) || (h[0] <= 0.0 && h[1] <= 0.0 && h[2] <= 0.0);
}

bool triangles_cross(const std::array<Point, 3>& a, const std::array<Point, 3>& b) {
  const Point of_a = heights(a, b);
  if (on_one_side(of_a)) return false;
  const Point of_b = heights(b, a);
  if (on_one_side(of_b)) return false;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t n = (k + 1) % 3;
    if (pierces(a[k], a[n], of_a[k], of_a[n], b[0], b[1], b[2])) return true;
    if (pierces(b[k], b[n], of_b[k], of_b[n], a[0], a[1], a[2])) return true;
  }
  return false;
}

}  // namespace

TriangleTree::TriangleTree(std::span<const std::uint32_t> triangles, std::span<const std::uint32_t> places,
                           std::span<const float> positions)
    : triangles_(triangles), positions_(positions), order_(triangles.size() / 3) {
  std::iota(order_.begin(), order_.end(), 0U);
  boxes_.resize(order_.size());
  std::vector<float> centres(triangles.size());
  for (std::size_t t = 0; t < order_.size(); ++t)
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t k = 0; k < 3; ++k)
        centres[3 * t + axis] += positions[std::size_t{3} * triangles[3 * t + k] + axis];
  if (!order_.empty()) build(0, static_cast<std::uint32_t>(order_.size()), centres);
  for (const std::uint32_t t : order_) {
    const std::uint32_t* corners = &triangles_[std::size_t{3} * t];
    corner_places_.push_back({places[corners[0]], places[corners[1]], places[corners[2]]});
  }
  fit(positions);
}

// Splits at the median along the longest side of the centres' box. Returns the node's number.
std::uint32_t TriangleTree::build(std::uint32_t first, std::uint32_t last,
                                  const std::vector<float>& centres) {
  const auto number = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({.box = model::empty_box, .first_triangle = first, .last_triangle = last});
  if (last - first <= leaf_triangles) return number;
  std::array<float, 3> least, most;
  least.fill(std::numeric_limits<float>::infinity());
  most.fill(-std::numeric_limits<float>::infinity());
  for (std::uint32_t i = first; i < last; ++i)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float x = centres[std::size_t{3} * order_[i] + axis];
      least[axis] = std::min(least[axis], x);
      most[axis] = std::max(most[axis], x);
    }
  std::size_t longest = 0;
  for (std::size_t axis = 1; axis < 3; ++axis)
    if (most[axis] - least[axis] > most[longest] - least[longest]) longest = axis;
  const std::uint32_t middle = first + (last - first) / 2;
  std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last,
                   [&](std::uint32_t a, std::uint32_t b) {
                     const float x = centres[std::size_t{3} * a + longest];
                     const float y = centres[std::size_t{3} * b + longest];
                     return x != y ? x < y : a < b;
                   });
  build(first, middle, centres);
  nodes_[number].second = build(middle, last, centres);
  return number;
}

void TriangleTree::fit(std::span<const float> positions) {
  positions_ = positions;
  for (std::size_t i = 0; i < order_.size(); ++i) {
    boxes_[i] = model::empty_box;
    for (std::size_t k = 0; k < 3; ++k) {
      const float* x = &positions_[std::size_t{3} * triangles_[std::size_t{3} * order_[i] + k]];
      const model::Quad corner{x[0], x[1], x[2], 0.0f};
      grow(boxes_[i], corner, corner);
    }
  }
  // Children come after their parents.
  for (std::size_t n = nodes_.size(); n-- > 0;) {
    Node& node = nodes_[n];
    node.box = model::empty_box;
    if (node.second != 0) {
      for (const std::size_t child : {n + 1, std::size_t{node.second}})
        grow(node.box, nodes_[child].box.low, nodes_[child].box.high);
      continue;
    }
    for (std::uint32_t i = node.first_triangle; i < node.last_triangle; ++i)
      grow(node.box, boxes_[i].low, boxes_[i].high);
  }
}

std::array<double, 3> TriangleTree::corner(std::uint32_t triangle, std::size_t k) const {
  const float* p = &positions_[std::size_t{3} * triangles_[std::size_t{3} * triangle + k]];
  return {double{p[0]}, double{p[1]}, double{p[2]}};
}

bool TriangleTree::neighbours(std::uint32_t a, std::uint32_t b) const {
  for (const std::uint32_t i : corner_places_[a])
    for (const std::uint32_t j : corner_places_[b])
      if (i == j) return true;
  return false;
}

bool TriangleTree::cross(std::uint32_t a, std::uint32_t b) const {
  if (neighbours(a, b)) return false;
  const std::uint32_t s = order_[a], t = order_[b];
  return triangles_cross({corner(s, 0), corner(s, 1), corner(s, 2)},
                         {corner(t, 0), corner(t, 1), corner(t, 2)});
}

// Which nodes contain a triangle with that flag.
std::vector<std::uint8_t> TriangleTree::nodes_with(std::span<const std::uint8_t> flags,
                                                   std::uint8_t flag) const {
  std::vector<std::uint8_t> has(nodes_.size(), 0);
  for (std::size_t n = nodes_.size(); n-- > 0;) {
    const Node& node = nodes_[n];
    if (node.second != 0)
      has[n] = has[n + 1] | has[node.second];
    else
      for (std::uint32_t i = node.first_triangle; i < node.last_triangle; ++i)
        if (flags[order_[i]] == flag) has[n] = 1;
  }
  return has;
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> TriangleTree::crossings(
    std::span<const std::uint8_t> asked, std::span<const std::uint8_t> known) const {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> found;
  if (nodes_.empty()) return found;
  const std::vector<std::uint8_t> has =
      asked.empty() ? std::vector<std::uint8_t>(nodes_.size(), 1) : nodes_with(asked, 1);
  const std::vector<std::uint8_t> is_open =
      known.empty() ? std::vector<std::uint8_t>(nodes_.size(), 1) : nodes_with(known, 0);
  const auto is_out = [&](std::uint32_t i) { return !asked.empty() && asked[order_[i]] == 0; };
  const auto is_known = [&](std::uint32_t i) { return !known.empty() && known[order_[i]] != 0; };
  std::vector<std::pair<std::uint32_t, std::uint32_t>> open{{0, 0}};
  while (!open.empty()) {
    const auto [a, b] = open.back();
    open.pop_back();
    if (has[a] == 0 || has[b] == 0 || (is_open[a] == 0 && is_open[b] == 0)) continue;
    const Node &x = nodes_[a], &y = nodes_[b];
    if (a == b && x.second != 0) {
      open.emplace_back(a + 1, a + 1);
      open.emplace_back(x.second, x.second);
      open.emplace_back(a + 1, x.second);
      continue;
    }
    if (a != b && !overlap(x.box, y.box)) continue;
    if (x.second == 0 && y.second == 0) {
      for (std::uint32_t i = x.first_triangle; i < x.last_triangle; ++i) {
        // Few triangles of a leaf reach into the other leaf.
        if (is_out(i) || !overlap(boxes_[i], y.box)) continue;
        for (std::uint32_t j = a == b ? i + 1 : y.first_triangle; j < y.last_triangle; ++j)
          if (overlap(boxes_[i], boxes_[j]) && !is_out(j) && !(is_known(i) && is_known(j)) && cross(i, j))
            found.push_back(std::minmax(order_[i], order_[j]));
      }
      continue;
    }
    // Descend into the node with more triangles.
    const bool opens_x = y.second == 0 || (x.second != 0 && x.last_triangle - x.first_triangle >=
                                                                y.last_triangle - y.first_triangle);
    open.emplace_back(opens_x ? a + 1 : a, opens_x ? b : b + 1);
    open.emplace_back(opens_x ? x.second : a, opens_x ? b : y.second);
  }
  return found;
}

std::optional<double> TriangleTree::hit(const std::array<double, 3>& from,
                                        const std::array<double, 3>& direction,
                                        std::uint32_t without_place) const {
  double nearest = std::numeric_limits<double>::infinity();
  const auto meets = [&](const model::Box& box) {
    double enter = 0.0, leave = nearest;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double least = double{box.low[axis]} - from[axis], most = double{box.high[axis]} - from[axis];
      if (direction[axis] == 0.0) {
        if (least > 0.0 || most < 0.0) return false;
        continue;
      }
      const double one = least / direction[axis], other = most / direction[axis];
      enter = std::max(enter, std::min(one, other));
      leave = std::min(leave, std::max(one, other));
    }
    return enter <= leave;
  };
  std::vector<std::uint32_t> open;
  if (!nodes_.empty()) open.push_back(0);
  while (!open.empty()) {
    const std::uint32_t n = open.back();
    open.pop_back();
    const Node& node = nodes_[n];
    if (!meets(node.box)) continue;
    if (node.second != 0) {
      open.insert(open.end(), {n + 1, node.second});
      continue;
    }
    for (std::uint32_t i = node.first_triangle; i < node.last_triangle; ++i) {
      const std::uint32_t t = order_[i];
      bool is_own = false;
      for (const std::uint32_t place : corner_places_[i]) is_own = is_own || place == without_place;
      if (is_own) continue;
      // Moeller and Trumbore.
      const Point a = corner(t, 0), ab = difference(corner(t, 1), a), ac = difference(corner(t, 2), a);
      const Point p = cross_product(direction, ac);
      const double volume = dot(ab, p);
      if (volume == 0.0) continue;
      const Point at = difference(from, a), q = cross_product(at, ab);
      const double u = dot(at, p) / volume, v = dot(direction, q) / volume, s = dot(ac, q) / volume;
      if (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && s > 0.0) nearest = std::min(nearest, s);
    }
  }
  if (nearest == std::numeric_limits<double>::infinity()) return std::nullopt;
  return nearest;
}

}  // namespace fascicle::bake
