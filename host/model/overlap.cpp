#include "host/model/overlap.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "host/model/boxes.h"
#include "host/model/contact_depth.h"
#include "host/model/contact_near.h"
#include "host/model/contact_order.h"

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

const std::uint32_t* corners(const Model& model, std::uint32_t t) {
  return model.contact_tetrahedron.data() + 4 * std::size_t{t};
}

// Each surface triangle's rest area, a third to each of its corners.
std::vector<double> areas(const Model& model) {
  std::vector<Triangle> sides;
  sides.reserve(model.tetrahedron.size());
  for (std::size_t t = 0; t < model.tetrahedron.size(); t += 4)
    for (std::size_t without = 0; without < 4; ++without) {
      Triangle side{};
      for (std::size_t k = 0, at = 0; k < 4; ++k)
        if (k != without) side[at++] = model.tetrahedron[t + k];
      const bool has_point = std::any_of(side.begin(), side.end(), [&](std::uint32_t i) {
        return model.contact_number[i] != shader::no_contact;
      });
      if (!has_point) continue;
      std::sort(side.begin(), side.end());
      sides.push_back(side);
    }
  std::sort(sides.begin(), sides.end());
  std::vector<double> area(model.contact.size(), 0.0);
  for (std::size_t first = 0, end = 0; first < sides.size(); first = end) {
    const Triangle& side = sides[first];
    while (end < sides.size() && sides[end] == side) ++end;
    if (end - first != 1) continue;
    const Vector a = place_of(model.rest, side[0]);
    const Vector normal =
        outer(minus(place_of(model.rest, side[1]), a), minus(place_of(model.rest, side[2]), a));
    for (const std::uint32_t i : side)
      if (model.contact_number[i] != shader::no_contact)
        area[model.contact_number[i]] += std::sqrt(inner(normal, normal)) / 6.0;
  }
  return area;
}

struct Place {
  Quad at;
};

Quad quad_of(std::span<const float> positions, std::size_t i) {
  return Quad{positions[3 * i], positions[3 * i + 1], positions[3 * i + 2], 0.0f};
}

struct Point {
  Quad at;
  std::uint32_t number;  // of Model::contact
};

// Many points, tested four at a time.
class Points {
 public:
  void add(const Point& point) {
    const std::size_t k = numbers_.size() % 4;
    if (k == 0) fours_.push_back({{nowhere, nowhere, nowhere}});
    for (int a = 0; a < 3; ++a) fours_.back().along[static_cast<std::size_t>(a)][k] = point.at[a];
    numbers_.push_back(point.number);
  }
  // Calls use(point) for the points in [first, end) inside the box; `first` is a multiple of 4.
  template <class Use>
  void for_each_in(const Box& box, std::size_t first, std::size_t end, const Use& use) const {
    for (std::size_t four = first / 4; 4 * four < end; ++four)
      for (std::uint32_t bits = held(box, fours_[four]); bits != 0; bits &= bits - 1) {
        const auto k = static_cast<std::size_t>(std::countr_zero(bits));
        if (4 * four + k >= end) break;
        const std::array<Quad, 3>& along = fours_[four].along;
        use(Point{{along[0][k], along[1][k], along[2][k], 0.0f}, numbers_[4 * four + k]});
      }
  }

 private:
  // All x, all y, all z.
  struct Four {
    std::array<Quad, 3> along;
  };
  static constexpr float no_number = std::numeric_limits<float>::quiet_NaN();
  static constexpr Quad nowhere = {no_number, no_number, no_number, no_number};

  // One bit for each point inside the box.
  static std::uint32_t held(const Box& box, const Four& four) {
    QuadFlags flags = {1, 2, 4, 8};
    for (int a = 0; a < 3; ++a) {
      const Quad x = four.along[static_cast<std::size_t>(a)];
      flags &= (x >= box.low[a]) & (x <= box.high[a]);
    }
    const auto halves = std::bit_cast<QuadHalves>(flags);
    const auto bits = static_cast<std::uint64_t>(halves[0] | halves[1]);
    return static_cast<std::uint32_t>(bits | bits >> 32);
  }

  std::vector<Four> fours_;
  std::vector<std::uint32_t> numbers_;
};

// A tetrahedron prepared for depth queries: its first corner, the gradients of the volumes that a point makes
// with its faces, and six times its volume.
struct Solid {
  Vector a, by_b, by_c, by_d;
  double whole;
};

Solid solid_of(const std::uint32_t* corner, std::span<const float> positions) {
  const Vector a = place_of(positions, corner[0]);
  const Vector ab = minus(place_of(positions, corner[1]), a), ac = minus(place_of(positions, corner[2]), a),
               ad = minus(place_of(positions, corner[3]), a);
  const Vector by_b = outer(ac, ad);
  return {a, by_b, outer(ad, ab), outer(ab, ac), inner(ab, by_b)};
}

// Barycentric weights of x in the tetrahedron; false if x is outside.
bool lies_in(const Solid& solid, const Vector& x, std::array<double, 4>& weight) {
  if (!(solid.whole > 0.0)) return false;
  const Vector ax = minus(x, solid.a);
  // Most points lie outside: return at the first face that x is behind.
  weight[1] = inner(ax, solid.by_b) / solid.whole;
  if (!(weight[1] >= 0.0)) return false;
  weight[2] = inner(ax, solid.by_c) / solid.whole;
  if (!(weight[2] >= 0.0)) return false;
  weight[3] = inner(ax, solid.by_d) / solid.whole;
  weight[0] = 1.0 - weight[1] - weight[2] - weight[3];
  return weight[3] >= 0.0 && weight[0] >= 0.0;
}

// A depth within this of the rest depth counts as rounding error; working units, which are about a body's
// size.
constexpr double least_deeper = 0x1p-20;

constexpr std::uint32_t block_size = 16;             // points
constexpr std::uint32_t leaf_size = 32;              // tetrahedra
constexpr std::uint32_t group_size = leaf_size / 4;  // tetrahedra, four groups per leaf
constexpr std::uint32_t fan = 4;                     // boxes per parent box

// Finds which points lie in which tetrahedra, for one shape. The boxes of tetrahedra form a tree; each box is
// tested only against the blocks of points that overlap its parent.
class OverlapSearch {
 public:
  OverlapSearch(const Model& model, const OverlapTables& tables, std::span<const float> positions);
  // By ascending point; depths in working units.
  std::vector<PointOverlap> find();

 private:
  void find_in(const OverlapTables::Part& part, std::uint32_t points);
  void find_in_box(const OverlapTables::Part& part, std::size_t level, std::uint32_t number,
                   std::size_t first, std::size_t end);
  void find_in_leaf(const OverlapTables::Part& part, std::uint32_t leaf, const Box& box, std::size_t first,
                    std::size_t end);
  void find_in_group(std::span<const std::uint32_t> tetrahedra);
  void find_in_tetrahedron(std::uint32_t t, const Box& box);
  bool may_meet(std::uint32_t p, std::uint32_t t, const std::array<double, 4>& weight) const;

  const Model& model_;
  const OverlapTables& tables_;
  std::span<const float> positions_;
  std::vector<Place> places_;            // one per vertex
  Points points_;                        // in the order of the tables; non-finite points are nowhere
  std::vector<Box> blocks_;              // one per block_size points
  std::vector<PointOverlap> found_;      // one per point; no_contact as tetrahedron if nothing was found
  std::vector<std::vector<Box>> boxes_;  // for the current part: around leaves, then around those, ...
  std::size_t asked_points_ = 0;         // the first so many points are searched for
  std::vector<std::uint32_t> near_;      // blocks that overlap the current boxes, the outermost box's first
  std::vector<Point> in_leaf_, in_group_;
};

OverlapSearch::OverlapSearch(const Model& model, const OverlapTables& tables,
                             std::span<const float> positions)
    : model_(model), tables_(tables), positions_(positions) {
  places_.reserve(model.vertex_count);
  for (std::size_t i = 0; i < model.vertex_count; ++i) places_.push_back({quad_of(positions, i)});
  for (std::size_t k = 0; k < tables.order.size(); ++k) {
    const Quad at = places_[model.contact[tables.order[k]].vertex].at;
    const Quad x = at + (at - at);  // non-finite becomes NaN
    if (k % block_size == 0) blocks_.push_back(empty_box);
    grow(blocks_.back(), x, x);
    points_.add({x, tables.order[k]});
  }
  found_.reserve(model.contact.size());
  for (std::uint32_t p = 0; p < model.contact.size(); ++p) found_.push_back({p, shader::no_contact, 0.0});
}

// Skips pairs where both point and tetrahedron follow the skeleton: often most of a hand, and everything that
// is only carried along.
std::vector<PointOverlap> OverlapSearch::find() {
  find_in(tables_.free, static_cast<std::uint32_t>(tables_.order.size()));
  find_in(tables_.held, tables_.free_points);
  std::erase_if(found_, [](const PointOverlap& one) { return one.tetrahedron == shader::no_contact; });
  return std::move(found_);
}

void OverlapSearch::find_in(const OverlapTables::Part& part, std::uint32_t points) {
  asked_points_ = points;
  boxes_.assign(1, {});
  for (std::size_t leaf = 0; leaf + 1 < part.leaf_offset.size(); ++leaf) {
    Box box = empty_box;
    for (std::uint32_t v = part.leaf_offset[leaf]; v < part.leaf_offset[leaf + 1]; ++v) {
      const Quad x = places_[part.leaf_vertex[v]].at;
      grow(box, x, x);
    }
    boxes_[0].push_back(box);
  }
  if (boxes_[0].empty()) return;
  while (boxes_.back().size() > 1) {
    std::vector<Box> around(parts_of(static_cast<std::uint32_t>(boxes_.back().size()), fan), empty_box);
    for (std::size_t k = 0; k < boxes_.back().size(); ++k)
      grow(around[k / fan], boxes_.back()[k].low, boxes_.back()[k].high);
    boxes_.push_back(std::move(around));
  }
  near_.resize(parts_of(points, block_size));
  std::iota(near_.begin(), near_.end(), 0U);
  find_in_box(part, boxes_.size() - 1, 0, 0, near_.size());
}

// [first, end) in near_ are the blocks near the parent box.
void OverlapSearch::find_in_box(const OverlapTables::Part& part, std::size_t level, std::uint32_t number,
                                std::size_t first, std::size_t end) {
  const Box& box = boxes_[level][number];
  for (std::size_t k = first; k < end; ++k)
    if (overlap(blocks_[near_[k]], box)) near_.push_back(near_[k]);
  if (near_.size() > end && level == 0) find_in_leaf(part, number, box, end, near_.size());
  if (near_.size() > end && level > 0) {
    const std::size_t last = near_.size(), boxes = boxes_[level - 1].size();
    for (std::uint32_t k = fan * number; k < fan * (number + 1) && k < boxes; ++k)
      find_in_box(part, level - 1, k, end, last);
  }
  near_.resize(end);
}

void OverlapSearch::find_in_leaf(const OverlapTables::Part& part, std::uint32_t leaf, const Box& box,
                                 std::size_t first, std::size_t end) {
  in_leaf_.clear();
  for (std::size_t n = first; n < end; ++n)
    points_.for_each_in(box, std::size_t{block_size} * near_[n],
                        std::min(std::size_t{block_size} * (near_[n] + 1), asked_points_),
                        [&](const Point& point) { in_leaf_.push_back(point); });
  if (in_leaf_.empty()) return;
  const std::span<const std::uint32_t> all = part.tetrahedron;
  for (std::size_t k = std::size_t{leaf_size} * leaf;
       k < all.size() && k < std::size_t{leaf_size} * (leaf + 1); k += group_size)
    find_in_group(all.subspan(k, std::min<std::size_t>(group_size, all.size() - k)));
}

void OverlapSearch::find_in_group(std::span<const std::uint32_t> tetrahedra) {
  std::array<Box, group_size> boxes;
  Box around = empty_box;
  for (std::size_t k = 0; k < tetrahedra.size(); ++k) {
    boxes[k] = empty_box;
    const std::uint32_t* corner = corners(model_, tetrahedra[k]);
    for (std::size_t c = 0; c < 4; ++c) grow(boxes[k], places_[corner[c]].at, places_[corner[c]].at);
    grow(around, boxes[k].low, boxes[k].high);
  }
  in_group_.clear();
  for (const Point& point : in_leaf_)
    if (holds(around, point.at)) in_group_.push_back(point);
  if (in_group_.empty()) return;
  for (std::size_t k = 0; k < tetrahedra.size(); ++k) find_in_tetrahedron(tetrahedra[k], boxes[k]);
}

// If several tetrahedra hold a point, the first one counts.
void OverlapSearch::find_in_tetrahedron(std::uint32_t t, const Box& box) {
  const std::uint32_t* corner = corners(model_, t);
  bool is_made = false;
  Solid solid{};
  for (const Point& point : in_group_) {
    if (!holds(box, point.at)) continue;
    const std::uint32_t p = point.number;
    PointOverlap& found = found_[p];
    // A point lies in its vertex's own tetrahedra, but does not meet them.
    const std::uint32_t vertex = model_.contact[p].vertex;
    if (found.tetrahedron < t || std::find(corner, corner + 4, vertex) != corner + 4) continue;
    if (!is_made) solid = solid_of(corner, positions_);
    is_made = true;
    std::array<double, 4> weight{};
    if (!lies_in(solid, place_of(positions_, vertex), weight) || !may_meet(p, t, weight)) continue;
    double deep = 0.0;
    for (std::size_t k = 0; k < 4; ++k) deep += weight[k] * double{contact_depth_of(model_, p, corner[k])};
    if (deep >= 0.0) found = {p, t, deep};
  }
}

// Whether a point may meet the location with these weights in tetrahedron t; at least one of the two can move
// freely.
bool OverlapSearch::may_meet(std::uint32_t p, std::uint32_t t, const std::array<double, 4>& weight) const {
  if (model_.is_ignored_contact(p, t)) return false;
  const shader::ContactPoint& point = model_.contact[p];
  const std::uint32_t* corner = corners(model_, t);
  const Vector rest = place_of(model_.rest, point.vertex);
  Vector apart{-rest[0], -rest[1], -rest[2]};
  for (std::size_t k = 0; k < 4; ++k) {
    const Vector r = place_of(model_.rest, corner[k]);
    for (std::size_t c = 0; c < 3; ++c) apart[c] += weight[k] * r[c];
  }
  if (inner(apart, apart) > double{point.margin} * double{point.margin}) return true;
  return std::all_of(corner, corner + 4, [&](std::uint32_t i) { return is_across_a_gap(model_, point, i); });
}

}  // namespace

OverlapTables::OverlapTables(const Model& model) : order(contact_points_along_curve(model)) {
  const auto is_free = [&](std::uint32_t i) { return !model.is_kinematic(i); };
  const auto first_held = std::stable_partition(
      order.begin(), order.end(), [&](std::uint32_t p) { return is_free(model.contact[p].vertex); });
  free_points = static_cast<std::uint32_t>(first_held - order.begin());
  for (std::uint32_t t = 0; t < model.contact_tetrahedron_count(); ++t) {
    const std::uint32_t* corner = corners(model, t);
    (std::any_of(corner, corner + 4, is_free) ? free : held).tetrahedron.push_back(t);
  }
  for (Part* part : {&free, &held}) {
    part->leaf_offset.push_back(0);
    for (std::size_t first = 0; first < part->tetrahedron.size(); first += leaf_size) {
      std::vector<std::uint32_t> vertices;
      for (std::size_t k = first; k < std::min(first + leaf_size, part->tetrahedron.size()); ++k) {
        const std::uint32_t* corner = corners(model, part->tetrahedron[k]);
        vertices.insert(vertices.end(), corner, corner + 4);
      }
      std::sort(vertices.begin(), vertices.end());
      part->leaf_vertex.insert(part->leaf_vertex.end(), vertices.begin(),
                               std::unique(vertices.begin(), vertices.end()));
      part->leaf_offset.push_back(static_cast<std::uint32_t>(part->leaf_vertex.size()));
    }
  }
}

OverlapMeter::OverlapMeter(const Model& model)
    : model_(model), tables_(model), area_(areas(model)), at_rest_(model.contact.size(), -1.0) {
  for (const PointOverlap& one : OverlapSearch(model, tables_, model.rest).find())
    at_rest_[one.point] = one.depth;
}

std::vector<PointOverlap> OverlapMeter::points(std::span<const float> positions) const {
  std::vector<PointOverlap> found = OverlapSearch(model_, tables_, positions).find();
  std::erase_if(found, [&](PointOverlap& one) {
    const double at_rest = at_rest_[one.point];
    if (at_rest >= 0.0 && !(one.depth > at_rest + least_deeper)) return true;
    one.depth = (one.depth - std::max(at_rest, 0.0)) * model_.unit;
    return false;
  });
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
