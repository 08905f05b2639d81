#include "host/model/overlap.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "host/model/contact_depth.h"

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

struct Box {
  std::array<float, 3> low, high;
};

constexpr float infinity = std::numeric_limits<float>::infinity();

// Around tetrahedron t. What is no number grows no box.
Box box_around(const Model& model, std::size_t t, std::span<const float> positions) {
  Box box{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
  for (std::size_t k = 0; k < 4; ++k) {
    const float* x = positions.data() + 3 * std::size_t{model.contact_tetrahedron[4 * t + k]};
    for (std::size_t a = 0; a < 3; ++a) {
      box.low[a] = std::min(box.low[a], x[a]);
      box.high[a] = std::max(box.high[a], x[a]);
    }
  }
  return box;
}

bool holds(const Box& box, const float* x) {
  for (std::size_t a = 0; a < 3; ++a)
    if (!(x[a] >= box.low[a] && x[a] <= box.high[a])) return false;
  return true;
}

// Points by the cell of a grid in which they are. The cells reach around nearly all of the points; the others
// are in the outermost ones.
class PointGrid {
 public:
  // About so large are the boxes that will be asked for, along each axis.
  PointGrid(const Model& model, std::span<const float> positions, float size) {
    std::vector<float> along;
    float cell = size;
    std::array<float, 3> reach{};
    for (std::size_t a = 0; a < 3; ++a) {
      along.clear();
      for (const shader::ContactPoint& point : model.contact)
        if (const float x = positions[3 * std::size_t{point.vertex} + a]; std::isfinite(x))
          along.push_back(x);
      if (along.empty()) return;
      const auto at_share = [&](double share) {
        const auto place =
            along.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(along.size() - 1));
        std::nth_element(along.begin(), place, along.end());
        return *place;
      };
      low_[a] = at_share(outside);
      reach[a] = at_share(1.0 - outside) - low_[a];
      cell = std::max(cell, reach[a] / static_cast<float>(most_cells));
    }
    if (!(cell > 0.0f) || !std::isfinite(cell)) return;
    inverse_cell_ = 1.0f / cell;
    for (std::size_t a = 0; a < 3; ++a)
      count_[a] = std::min(static_cast<std::size_t>(reach[a] * inverse_cell_) + 1, most_cells + 1);
    first_.assign(count_[0] * count_[1] * count_[2] + 1, 0);
    std::vector<std::size_t> cell_of(model.contact.size(), no_cell);
    for (std::size_t p = 0; p < cell_of.size(); ++p) {
      const float* x = positions.data() + 3 * std::size_t{model.contact[p].vertex};
      if (!(std::isfinite(x[0]) && std::isfinite(x[1]) && std::isfinite(x[2]))) continue;
      cell_of[p] = cell_at({place(x[0], 0), place(x[1], 1), place(x[2], 2)});
      ++first_[cell_of[p] + 1];
    }
    for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
    points_.resize(first_.back());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t p = 0; p < cell_of.size(); ++p)
      if (cell_of[p] != no_cell) {
        const float* x = positions.data() + 3 * std::size_t{model.contact[p].vertex};
        points_[next[cell_of[p]]++] = {{x[0], x[1], x[2]}, static_cast<std::uint32_t>(p)};
      }
  }

  // Calls use(p) for all points that lie in a box.
  template <class Use>
  void for_each_in(const Box& box, const Use& use) const {
    if (points_.empty()) return;
    std::array<std::size_t, 3> begin{}, end{};
    for (std::size_t a = 0; a < 3; ++a) {
      if (!(box.low[a] <= box.high[a])) return;
      begin[a] = place(box.low[a], a);
      end[a] = place(box.high[a], a);
    }
    for (std::size_t z = begin[2]; z <= end[2]; ++z)
      for (std::size_t y = begin[1]; y <= end[1]; ++y) {
        // Cells along x follow each other.
        const std::uint32_t last = first_[cell_at({end[0], y, z}) + 1];
        for (std::uint32_t k = first_[cell_at({begin[0], y, z})]; k < last; ++k)
          if (holds(box, points_[k].place.data())) use(points_[k].number);
      }
  }

 private:
  struct Point {
    std::array<float, 3> place;
    std::uint32_t number;
  };
  static constexpr double outside = 0.01;  // share of the points that the cells may leave out on each side
  static constexpr std::size_t most_cells = 128;  // along an axis
  static constexpr std::size_t no_cell = std::numeric_limits<std::size_t>::max();

  std::size_t place(float x, std::size_t a) const {
    const float along = (x - low_[a]) * inverse_cell_;
    return static_cast<std::size_t>(std::clamp(along, 0.0f, static_cast<float>(count_[a] - 1)));
  }
  std::size_t cell_at(const std::array<std::size_t, 3>& at) const {
    return (at[2] * count_[1] + at[1]) * count_[0] + at[0];
  }

  std::array<float, 3> low_{};
  float inverse_cell_ = 1.0f;
  std::array<std::size_t, 3> count_{};
  std::vector<std::uint32_t> first_;
  std::vector<Point> points_;  // cell by cell
};

// Whether a tetrahedron lies wholly within the margin of a point at rest, so that it cannot be met.
bool is_near_at_rest(const Model& model, const shader::ContactPoint& point, std::size_t t) {
  if (point.near_count > 0) return false;
  const float* s = model.rest.data() + 3 * std::size_t{point.vertex};
  // The share is kernel/contact.inc's: a little less than 1, as what decides is rounded.
  const float most = 0.99f * (point.margin * point.margin);
  for (std::size_t k = 0; k < 4; ++k) {
    const float* x = model.rest.data() + 3 * std::size_t{model.contact_tetrahedron[4 * t + k]};
    float sum = 0.0f;
    for (std::size_t a = 0; a < 3; ++a) sum += (x[a] - s[a]) * (x[a] - s[a]);
    if (!(sum < most)) return false;
  }
  return true;
}

// Of the boxes of tetrahedra at rest, along all axes, in the mean.
float mean_box_size(const Model& model) {
  double sum = 0.0;
  for (std::size_t t = 0; t < model.contact_tetrahedron_count(); ++t) {
    const Box box = box_around(model, t, model.rest);
    for (std::size_t a = 0; a < 3; ++a) sum += double{box.high[a]} - double{box.low[a]};
  }
  return static_cast<float>(sum / (3.0 * model.contact_tetrahedron_count()));
}

}  // namespace

OverlapMeter::OverlapMeter(const Model& model)
    : model_(model), area_(areas(model)), box_size_(mean_box_size(model)) {}

double OverlapMeter::depth_in(std::uint32_t p, std::uint32_t t, std::span<const float> positions) const {
  if (model_.is_ignored_contact(p, t)) return -1.0;
  const shader::ContactPoint& point = model_.contact[p];
  const std::uint32_t* corner = model_.contact_tetrahedron.data() + 4 * std::size_t{t};
  const Vector a = place_of(positions, corner[0]);
  const Vector ab = minus(place_of(positions, corner[1]), a), ac = minus(place_of(positions, corner[2]), a),
               ad = minus(place_of(positions, corner[3]), a),
               ax = minus(place_of(positions, point.vertex), a);
  // Most points lie beside the tetrahedron: the first face that they lie behind ends the look.
  const Vector by_b = outer(ac, ad);
  const double whole = inner(ab, by_b);
  if (!(whole > 0.0)) return -1.0;
  std::array<double, 4> weight{0.0, inner(ax, by_b) / whole, 0.0, 0.0};
  if (!(weight[1] >= 0.0)) return -1.0;
  weight[2] = inner(ax, outer(ad, ab)) / whole;
  if (!(weight[2] >= 0.0)) return -1.0;
  weight[3] = inner(ax, outer(ab, ac)) / whole;
  weight[0] = 1.0 - weight[1] - weight[2] - weight[3];
  if (!(weight[3] >= 0.0) || !(weight[0] >= 0.0)) return -1.0;
  const Vector rest = place_of(model_.rest, point.vertex);
  const auto first_near = model_.contact_near.begin() + point.first_near;
  Vector apart{-rest[0], -rest[1], -rest[2]};
  double deep = 0.0;
  bool is_free = !model_.is_kinematic(point.vertex), is_across_a_gap = true;
  for (std::size_t k = 0; k < 4; ++k) {
    const Vector r = place_of(model_.rest, corner[k]);
    for (std::size_t c = 0; c < 3; ++c) apart[c] += weight[k] * r[c];
    deep += weight[k] * double{contact_depth_of(model_, p, corner[k])};
    is_free = is_free || !model_.is_kinematic(corner[k]);
    is_across_a_gap =
        is_across_a_gap && std::binary_search(first_near, first_near + point.near_count, corner[k]);
  }
  const bool is_far = inner(apart, apart) > double{point.margin} * double{point.margin};
  return is_free && (is_far || is_across_a_gap) ? deep : -1.0;
}

// Tetrahedra come in their order, so that a point's first find is that of the lowest number.
std::vector<PointOverlap> OverlapMeter::points(std::span<const float> positions) const {
  const PointGrid grid(model_, positions, box_size_);
  std::vector<std::optional<PointOverlap>> found(model_.contact.size());
  for (std::uint32_t t = 0; t < model_.contact_tetrahedron_count(); ++t) {
    grid.for_each_in(box_around(model_, t, positions), [&](std::uint32_t p) {
      if (found[p] || is_near_at_rest(model_, model_.contact[p], t)) return;
      if (const double deep = depth_in(p, t, positions); deep >= 0.0)
        found[p] = PointOverlap{p, t, deep * model_.unit};
    });
  }
  std::vector<PointOverlap> overlaps;
  for (const std::optional<PointOverlap>& one : found)
    if (one) overlaps.push_back(*one);
  return overlaps;
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
