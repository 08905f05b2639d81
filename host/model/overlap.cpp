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
  for (std::size_t t = 0; t < model.contact_tetrahedron.size(); t += 4)
    for (std::size_t without = 0; without < 4; ++without) {
      Triangle side{};
      for (std::size_t k = 0, at = 0; k < 4; ++k)
        if (k != without) side[at++] = model.contact_tetrahedron[t + k];
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

bool holds(const float* box, const Vector& x) {
  for (std::size_t a = 0; a < 3; ++a)
    if (!(x[a] >= double{box[a]} && x[a] <= double{box[3 + a]})) return false;
  return true;
}

}  // namespace

OverlapMeter::OverlapMeter(const Model& model) : model_(model), area_(areas(model)) {}

double OverlapMeter::depth(std::uint32_t p, std::span<const float> positions,
                           std::span<const float> boxes) const {
  const shader::ContactPoint& point = model_.contact[p];
  const Vector x = place_of(positions, point.vertex), rest = place_of(model_.rest, point.vertex);
  const auto first_near = model_.contact_near.begin() + point.first_near;
  for (std::uint32_t leaf = 0; 6 * leaf < boxes.size(); ++leaf) {
    if (!holds(boxes.data() + 6 * std::size_t{leaf}, x)) continue;
    const std::uint32_t end = std::min((leaf + 1) * shader::contact_leaf, model_.contact_tetrahedron_count());
    for (std::uint32_t t = leaf * shader::contact_leaf; t < end; ++t) {
      const std::uint32_t* corner = model_.contact_tetrahedron.data() + 4 * std::size_t{t};
      const Vector a = place_of(positions, corner[0]);
      const Vector ab = minus(place_of(positions, corner[1]), a),
                   ac = minus(place_of(positions, corner[2]), a),
                   ad = minus(place_of(positions, corner[3]), a), ax = minus(x, a);
      const double whole = inner(ab, outer(ac, ad));
      if (!(whole > 0.0)) continue;
      std::array<double, 4> weight{0.0, inner(ax, outer(ac, ad)) / whole, inner(ax, outer(ad, ab)) / whole,
                                   inner(ax, outer(ab, ac)) / whole};
      weight[0] = 1.0 - weight[1] - weight[2] - weight[3];
      if (*std::min_element(weight.begin(), weight.end()) < 0.0) continue;
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
      if (is_free && (is_far || is_across_a_gap)) return deep;
    }
  }
  return -1.0;
}

Overlap OverlapMeter::of(std::span<const float> positions) const {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  std::vector<float> boxes;
  for (std::uint32_t leaf = 0; leaf < model_.contact_leaf_count(); ++leaf) {
    std::array<float, 6> box{infinity, infinity, infinity, -infinity, -infinity, -infinity};
    const std::size_t first = 4 * std::size_t{leaf} * shader::contact_leaf,
                      end = std::min(first + 4 * std::size_t{shader::contact_leaf},
                                     model_.contact_tetrahedron.size());
    for (std::size_t e = first; e < end; ++e)
      for (std::size_t a = 0; a < 3; ++a) {
        const float x = positions[3 * std::size_t{model_.contact_tetrahedron[e]} + a];
        box[a] = std::min(box[a], x);
        box[3 + a] = std::max(box[3 + a], x);
      }
    boxes.insert(boxes.end(), box.begin(), box.end());
  }
  Overlap overlap;
  for (std::uint32_t p = 0; p < model_.contact.size(); ++p) {
    const double deep = depth(p, positions, boxes);
    if (deep < 0.0) continue;
    ++overlap.vertices;
    overlap.deepest = std::max(overlap.deepest, deep * model_.unit);
    overlap.volume += area_[p] * deep / 2.0 * model_.unit * model_.unit * model_.unit;
  }
  return overlap;
}

}  // namespace fascicle::model
