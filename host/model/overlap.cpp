#include "host/model/overlap.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

namespace fascicle::model {

namespace {

using Vector = std::array<double, 3>;
using Triangle = std::array<std::uint32_t, 3>;

Vector place_of(std::span<const float> positions, std::uint32_t i) {
  return {double{positions[3 * i]}, double{positions[3 * i + 1]}, double{positions[3 * i + 2]}};
}

Vector minus(const Vector& a, const Vector& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

double inner(const Vector& a, const Vector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Vector outer(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// A third of each triangle of the surface, at rest, for each of its corners.
std::vector<double> areas(const Model& model) {
  std::map<Triangle, int> sides;
  for (std::size_t t = 0; t < model.tetrahedron.size(); t += 4)
    for (std::size_t without = 0; without < 4; ++without) {
      Triangle side{};
      for (std::size_t k = 0, at = 0; k < 4; ++k)
        if (k != without) side[at++] = model.tetrahedron[t + k];
      std::sort(side.begin(), side.end());
      ++sides[side];
    }
  std::vector<double> area(model.contact.size(), 0.0);
  for (const auto& [side, tetrahedra] : sides) {
    if (tetrahedra != 1) continue;
    const Vector a = place_of(model.rest, side[0]);
    const Vector normal =
        outer(minus(place_of(model.rest, side[1]), a), minus(place_of(model.rest, side[2]), a));
    for (const std::uint32_t i : side)
      if (model.contact_number[i] != shader::no_contact)
        area[model.contact_number[i]] += std::sqrt(inner(normal, normal)) / 6.0;
  }
  return area;
}

bool holds(const float* box, const float* x) {
  for (std::size_t a = 0; a < 3; ++a)
    if (!(x[a] >= box[a] && x[a] <= box[3 + a])) return false;
  return true;
}

// Whether all of a box at rest lies within the margin of a point.
bool is_near(const float* box, const float* rest, float margin) {
  float sum = 0.0f;
  for (std::size_t a = 0; a < 3; ++a) {
    const float farthest = std::max(rest[a] - box[a], box[4 + a] - rest[a]);
    sum += farthest * farthest;
  }
  return sum < 0.99f * margin * margin;
}

using Boxes = std::vector<float>;
constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr std::array<float, 6> no_box{infinity, infinity, infinity, -infinity, -infinity, -infinity};

void grow(float* box, const float* low, const float* high) {
  for (std::size_t a = 0; a < 3; ++a) {
    box[a] = std::min(box[a], low[a]);
    box[3 + a] = std::max(box[3 + a], high[a]);
  }
}

// Around each tetrahedron. They are made once a frame: points ask for the same ones again and again.
Boxes tetrahedron_boxes(const Model& model, std::span<const float> positions) {
  Boxes boxes(6 * std::size_t{model.contact_tetrahedron_count()});
  for (std::size_t t = 0; t < model.contact_tetrahedron_count(); ++t) {
    float* box = boxes.data() + 6 * t;
    std::copy(no_box.begin(), no_box.end(), box);
    for (std::size_t k = 0; k < 4; ++k) {
      const float* x = positions.data() + 3 * std::size_t{model.contact_tetrahedron[4 * t + k]};
      grow(box, x, x);
    }
  }
  return boxes;
}

// Around each `size` of the boxes in turn.
Boxes boxes_around(const Boxes& parts, std::uint32_t size) {
  Boxes boxes;
  for (std::size_t k = 0; 6 * k < parts.size(); ++k) {
    if (k % size == 0) boxes.insert(boxes.end(), no_box.begin(), no_box.end());
    grow(boxes.data() + boxes.size() - 6, parts.data() + 6 * k, parts.data() + 6 * k + 3);
  }
  return boxes;
}

}  // namespace

OverlapMeter::OverlapMeter(const Model& model) : model_(model), area_(areas(model)) {}

double OverlapMeter::depth_in(std::uint32_t p, std::uint32_t t, std::span<const float> positions) const {
  if (model_.is_ignored_contact(p, t)) return -1.0;
  const shader::ContactPoint& point = model_.contact[p];
  const std::uint32_t* corner = model_.contact_tetrahedron.data() + 4 * std::size_t{t};
  const Vector a = place_of(positions, corner[0]);
  const Vector ab = minus(place_of(positions, corner[1]), a), ac = minus(place_of(positions, corner[2]), a),
               ad = minus(place_of(positions, corner[3]), a),
               ax = minus(place_of(positions, point.vertex), a);
  const double whole = inner(ab, outer(ac, ad));
  if (!(whole > 0.0)) return -1.0;
  std::array<double, 4> weight{0.0, inner(ax, outer(ac, ad)) / whole, inner(ax, outer(ad, ab)) / whole,
                               inner(ax, outer(ab, ac)) / whole};
  weight[0] = 1.0 - weight[1] - weight[2] - weight[3];
  if (*std::min_element(weight.begin(), weight.end()) < 0.0) return -1.0;
  const Vector rest = place_of(model_.rest, point.vertex);
  const auto first_near = model_.contact_near.begin() + point.first_near;
  Vector apart{-rest[0], -rest[1], -rest[2]};
  double deep = 0.0;
  bool is_free = !model_.is_kinematic(point.vertex), is_across_a_gap = true;
  for (std::size_t k = 0; k < 4; ++k) {
    const Vector r = place_of(model_.rest, corner[k]);
    for (std::size_t c = 0; c < 3; ++c) apart[c] += weight[k] * r[c];
    deep += weight[k] * double{model_.contact_depth[corner[k]]};
    is_free = is_free || !model_.is_kinematic(corner[k]);
    is_across_a_gap =
        is_across_a_gap && std::binary_search(first_near, first_near + point.near_count, corner[k]);
  }
  const bool is_far = inner(apart, apart) > double{point.margin} * double{point.margin};
  return is_free && (is_far || is_across_a_gap) ? deep : -1.0;
}

std::optional<PointOverlap> OverlapMeter::overlap_of(std::uint32_t p, std::span<const float> positions,
                                                     const AllBoxes& boxes) const {
  const shader::ContactPoint& point = model_.contact[p];
  const float* x = positions.data() + 3 * std::size_t{point.vertex};
  const float* rest = model_.rest.data() + 3 * std::size_t{point.vertex};
  const std::uint32_t leaf_count = model_.contact_leaf_count();
  const auto may_hold = [&](const Boxes& of_level, std::uint32_t box, std::uint32_t rest_box) {
    return holds(of_level.data() + 6 * std::size_t{box}, x) &&
           (point.near_count > 0 ||
            !is_near(model_.contact_rest_box.data() + 8 * std::size_t{rest_box}, rest, point.margin));
  };
  for (std::uint32_t branch = 0; branch < model_.contact_branch_count(); ++branch) {
    if (!may_hold(boxes.branches, branch, leaf_count + branch)) continue;
    const std::uint32_t last_leaf = std::min((branch + 1) * shader::contact_branch, leaf_count);
    for (std::uint32_t leaf = branch * shader::contact_branch; leaf < last_leaf; ++leaf) {
      if (!may_hold(boxes.leaves, leaf, leaf)) continue;
      const std::uint32_t last =
          std::min((leaf + 1) * shader::contact_leaf, model_.contact_tetrahedron_count());
      for (std::uint32_t t = leaf * shader::contact_leaf; t < last; ++t) {
        if (!holds(boxes.tetrahedra.data() + 6 * std::size_t{t}, x)) continue;
        if (const double deep = depth_in(p, t, positions); deep >= 0.0)
          return PointOverlap{p, t, deep * model_.unit};
      }
    }
  }
  return std::nullopt;
}

std::vector<PointOverlap> OverlapMeter::points(std::span<const float> positions) const {
  AllBoxes boxes;
  boxes.tetrahedra = tetrahedron_boxes(model_, positions);
  boxes.leaves = boxes_around(boxes.tetrahedra, shader::contact_leaf);
  boxes.branches = boxes_around(boxes.leaves, shader::contact_branch);
  std::vector<PointOverlap> found;
  for (std::uint32_t p = 0; p < model_.contact.size(); ++p)
    if (const std::optional<PointOverlap> one = overlap_of(p, positions, boxes)) found.push_back(*one);
  return found;
}

Overlap OverlapMeter::of(std::span<const float> positions) const {
  Overlap overlap;
  for (const PointOverlap& one : points(positions)) {
    ++overlap.vertices;
    overlap.deepest = std::max(overlap.deepest, one.depth);
    overlap.volume += area_[one.point] * one.depth / 2.0 * model_.unit * model_.unit;
  }
  return overlap;
}

}  // namespace fascicle::model
