#include "host/build/contacts.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <queue>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "host/base/parallel.h"
#include "host/base/text.h"
#include "host/build/boundary.h"
#include "host/build/box_tree.h"
#include "host/build/limits.h"
#include "host/build/message.h"
#include "host/build/points.h"
#include "host/build/surface_search.h"
#include "host/model/contact_depth.h"
#include "host/model/contact_near.h"

namespace fascicle::build {

namespace {

using Eigen::Vector3d;
using model::Model;
using Triangle = std::array<std::uint32_t, 3>;

// The default margin in mean edges of the surface. Below two, flesh met its own neighbours where a
// character's cage is coarse; from three on, more volume stays in folds.
constexpr double margin_edges = 2.0;
// The maximum margin in diagonals of the body, or in mean edges if that is more, for coarse meshes. Every
// point tests all vertices within some margins.
constexpr double most_diagonals = 0.1, most_edges = 4.0;
// The minimum margin in mean edges: below this, it vanishes next to them in single precision.
constexpr double least_edges = 1e-6;
// How far around a point to look for vertices across a gap, in margins, and how many times that distance the
// path along the flesh must be.
constexpr double gap_margins = 1.5;
constexpr double gap_detour = 3.0;

std::vector<Vector3d> rest_places(const Model& model) {
  std::vector<Vector3d> places;
  places.reserve(model.vertex_count);
  for (std::size_t i = 0; i < model.vertex_count; ++i) places.push_back(vector_at(model.rest, i));
  return places;
}

double mean_edge(const std::vector<Triangle>& triangles, const std::vector<Vector3d>& rest) {
  double sum = 0.0;
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) sum += (rest[t[k]] - rest[t[(k + 1) % 3]]).norm();
  return sum / (3.0 * static_cast<double>(triangles.size()));
}

// In working units.
double margin_of(const scene::ContactSettings& settings, const std::vector<Vector3d>& rest, double edge,
                 const std::string& source, double unit) {
  if (!settings.distance) return margin_edges * edge;
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : rest) box.extend(p);
  const double margin = *settings.distance / unit,
               most = std::max(most_diagonals * box.diagonal().norm(), most_edges * edge);
  // Rounded towards the valid range, so that the printed value is accepted.
  const auto metres = [&](double length) {
    return base::number_text(static_cast<float>((1.0 - 1e-6) * length * unit)) + " m";
  };
  if (margin > most)
    fail(source, "contact.distance: " + base::number_text(*settings.distance) +
                     " m is too far for a body of this size; give at most " + metres(most) +
                     ", or leave it out for " + metres(margin_edges * edge));
  if (margin < least_edges * edge)
    fail(source, "contact.distance: " + base::number_text(*settings.distance) +
                     " m is too small for a body of this size; give at least " +
                     metres((1.0 + 2e-6) * least_edges * edge) + ", or leave it out for " +
                     metres(margin_edges * edge));
  return margin;
}

// The boundary of the tetrahedra in contact_tetrahedron for which is_met(t): the body's surface, and the
// border of flesh that is not met. A point that comes in through such flesh then finds a way out as long as
// its way in.
template <class IsMet>
std::vector<Triangle> boundary_of_met(const Model& model, const std::vector<Vector3d>& rest,
                                      const std::string& source, const IsMet& is_met) {
  mesh::TetMesh met{rest, {}};
  for (std::size_t t = 0; t < model.contact_tetrahedron_count(); ++t) {
    const std::uint32_t* corner = model.contact_tetrahedron.data() + 4 * t;
    if (is_met(t)) met.tetrahedra.push_back({corner[0], corner[1], corner[2], corner[3]});
  }
  return boundary_triangles(met, source);
}

// For each vertex the distance to these triangles at rest, 0 at their corners.
std::vector<float> depths(const std::vector<Triangle>& triangles, const std::vector<Vector3d>& rest) {
  std::vector<char> is_on_surface(rest.size(), 0);
  for (const Triangle& t : triangles)
    for (const std::uint32_t i : t) is_on_surface[i] = 1;
  mesh::SurfaceMesh surface;
  surface.vertices = rest;
  surface.triangles = triangles;
  std::vector<float> depth(rest.size(), 0.0f);
  if (triangles.empty()) return depth;
  const SurfaceSearch search(surface);
  base::for_each_in_parallel(rest.size(), base::thread_count(), [&](std::size_t i, std::size_t) {
    if (!is_on_surface[i]) depth[i] = model::as_factor(search.nearest(rest[i]).distance);
  });
  return depth;
}

// Spreads the bits of a number below 2^20 to every third place.
std::uint64_t spread(std::uint64_t number) {
  std::uint64_t bits = 0;
  for (unsigned b = 0; b < 20; ++b) bits |= (number >> b & 1U) << (3 * b);
  return bits;
}

// A tetrahedron with this many corners of some flesh belongs to that flesh.
constexpr int enough_corners = 2;

bool meets_nothing(const ContactGroups& groups, std::uint32_t vertex) {
  return !groups.meets_nothing.empty() && groups.meets_nothing[vertex] != 0;
}

// The tetrahedra that can be met, along a Morton curve, so that leaves and branches are small. Four corners
// per tetrahedron.
std::vector<std::uint32_t> ordered_tetrahedra(const Model& model, const std::vector<Vector3d>& rest,
                                              const ContactGroups& groups) {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order;
  for (std::uint32_t t = 0; t < model.tetrahedron_count(); ++t) {
    const auto corner = model.tetrahedron.begin() + std::ptrdiff_t{4} * t;
    if (std::count_if(corner, corner + 4, [&](std::uint32_t i) { return meets_nothing(groups, i); }) >=
        enough_corners)
      continue;
    Vector3d sum = Vector3d::Zero();
    for (std::size_t k = 0; k < 4; ++k) sum += rest[model.tetrahedron[4 * std::size_t{t} + k]];
    std::uint64_t code = 0;
    for (int a = 0; a < 3; ++a) {
      // Rest coordinates lie in [-1, 1].
      const double along = (sum[a] / 4.0 + 1.0) / 2.0 * 0x1p20;
      code |= spread(static_cast<std::uint64_t>(std::clamp(along, 0.0, 0x1p20 - 1.0))) << a;
    }
    order.emplace_back(code, t);
  }
  std::sort(order.begin(), order.end());
  std::vector<std::uint32_t> corners;
  corners.reserve(4 * order.size());
  for (const auto& [code, t] : order)
    for (std::size_t k = 0; k < 4; ++k) corners.push_back(model.tetrahedron[4 * std::size_t{t} + k]);
  return corners;
}

// The groups that points ignore, and the tetrahedra's own among them; nothing if no group ignores another.
void write_groups(const ContactGroups& groups, Model& model) {
  if (groups.groups.empty()) return;
  const auto for_each_group = [](std::uint32_t bits, const auto& use) {
    for (; bits != 0; bits &= bits - 1) use(static_cast<std::size_t>(std::countr_zero(bits)));
  };
  std::uint32_t of_tetrahedra = 0, of_points = 0;
  for (std::size_t t = 0; t < model.contact_tetrahedron.size(); t += 4) {
    std::array<int, scene::most_ignored_names> corners{};
    for (std::size_t k = 0; k < 4; ++k)
      for_each_group(groups.groups[model.contact_tetrahedron[t + k]],
                     [&](std::size_t group) { ++corners[group]; });
    std::uint32_t of = 0;
    for (std::size_t group = 0; group < corners.size(); ++group)
      if (corners[group] >= enough_corners) of |= 1U << group;
    model.contact_group.push_back(of);
    of_tetrahedra |= of;
  }
  for (const shader::ContactPoint& point : model.contact) {
    std::uint32_t ignored = 0;
    for_each_group(groups.groups[point.vertex], [&](std::size_t group) { ignored |= groups.ignored[group]; });
    model.contact_ignored.push_back(ignored & of_tetrahedra);
    of_points |= model.contact_ignored.back();
  }
  for (std::uint32_t& of : model.contact_group) of &= of_points;
  if (of_points != 0) return;
  model.contact_ignored.clear();
  model.contact_group.clear();
}

// Whether any point can meet any tetrahedron according to the groups.
bool can_meet(const Model& model) {
  if (model.contact_group.empty()) return true;
  const std::set<std::uint32_t> of_points(model.contact_ignored.begin(), model.contact_ignored.end()),
      of_tetrahedra(model.contact_group.begin(), model.contact_group.end());
  for (const std::uint32_t ignored : of_points)
    for (const std::uint32_t of : of_tetrahedra)
      if ((ignored & of) == 0) return true;
  return false;
}

// Clears the arrays that are set before gaps are searched.
void take_contact_away(Model& model) {
  model.contact_tetrahedron.clear();
  model.contact_depth.clear();
  model.contact_number.clear();
  model.contact.clear();
  model.contact_group.clear();
  model.contact_ignored.clear();
}

void write_group_depths(const std::vector<Vector3d>& rest, const std::string& source, Model& model) {
  const std::size_t count = model::contact_group_count(model);
  for (std::size_t group = 0; group < count; ++group) {
    const std::vector<float> of_group =
        depths(boundary_of_met(model, rest, source,
                               [&](std::size_t t) { return (model.contact_group[t] >> group & 1U) == 0; }),
               rest);
    model.contact_depth.insert(model.contact_depth.end(), of_group.begin(), of_group.end());
  }
}

void write_entries(Model& model) {
  std::vector<std::uint32_t>& offset = model.contact_offset;
  offset.assign(std::size_t{model.vertex_count} + 1, 0);
  for (const std::uint32_t i : model.contact_tetrahedron) ++offset[i + 1];
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) offset[i + 1] += offset[i];
  model.contact_entry.resize(model.contact_tetrahedron.size());
  std::vector<std::uint32_t> next(offset.begin(), offset.end() - 1);
  for (std::uint32_t e = 0; e < model.contact_tetrahedron.size(); ++e)
    model.contact_entry[next[model.contact_tetrahedron[e]]++] = e;
}

struct FloatBox {
  std::array<float, 3> low{}, high{};
};

void append(std::vector<float>& boxes, const FloatBox& box) {
  for (const std::array<float, 3>& side : {box.low, box.high}) {
    boxes.insert(boxes.end(), side.begin(), side.end());
    boxes.push_back(0.0f);
  }
}

// One box around every `size` consecutive boxes.
template <class BoxOf>
std::vector<FloatBox> boxes_around(std::uint32_t count, std::uint32_t size, const BoxOf& box_of) {
  std::vector<FloatBox> boxes;
  for (std::uint32_t k = 0; k < count; ++k) {
    const FloatBox part = box_of(k);
    if (k % size == 0) boxes.push_back(part);
    for (std::size_t a = 0; a < 3; ++a) {
      boxes.back().low[a] = std::min(boxes.back().low[a], part.low[a]);
      boxes.back().high[a] = std::max(boxes.back().high[a], part.high[a]);
    }
  }
  return boxes;
}

void write_rest_boxes(Model& model) {
  const std::uint32_t size = 4 * shader::contact_leaf;
  const auto corners = static_cast<std::uint32_t>(model.contact_tetrahedron.size());
  const std::vector<FloatBox> leaves = boxes_around(corners, size, [&](std::uint32_t e) {
    const float* x = model.rest.data() + 3 * std::size_t{model.contact_tetrahedron[e]};
    return FloatBox{{x[0], x[1], x[2]}, {x[0], x[1], x[2]}};
  });
  const std::vector<FloatBox> branches =
      boxes_around(static_cast<std::uint32_t>(leaves.size()), shader::contact_branch,
                   [&](std::uint32_t leaf) { return leaves[leaf]; });
  for (const std::vector<FloatBox>* level : {&leaves, &branches})
    for (const FloatBox& box : *level) append(model.contact_rest_box, box);
}

// Which vertices lie close to each other across a gap.
class GapSearch {
 public:
  GapSearch(const Model& model, const std::vector<Vector3d>& rest, double reach)
      : model_(model), rest_(rest), reach_(reach), tree_(boxes_of(rest)) {}

  // Per-thread working memory.
  struct Walk {
    std::vector<double> way;
    std::vector<std::uint32_t> touched;
    std::vector<char> is_asked;
  };

  // Vertices nearer to `from` than the reach for which the path along the flesh's edges is at least
  // gap_detour times the reach; ascending. As runs: where many parts lie in one place, the vertices
  // themselves would take memory by the square of their number.
  std::vector<shader::VertexRun> across_from(std::uint32_t from, Walk& walk) const {
    walk.way.resize(rest_.size(), std::numeric_limits<double>::infinity());
    walk.is_asked.resize(rest_.size(), 0);
    std::vector<std::uint32_t> asked;
    tree_.visit_near(rest_[from], reach_ * reach_, [&](std::uint32_t i) {
      // The tree also visits the others in a leaf.
      if ((rest_[i] - rest_[from]).squaredNorm() <= reach_ * reach_) {
        asked.push_back(i);
        walk.is_asked[i] = 1;
      }
      return reach_ * reach_;
    });
    walk_along(from, asked.size(), walk);
    std::vector<std::uint32_t> across;
    for (const std::uint32_t i : asked) {
      if (std::isinf(walk.way[i])) across.push_back(i);
      walk.is_asked[i] = 0;
    }
    for (const std::uint32_t i : walk.touched) walk.way[i] = std::numeric_limits<double>::infinity();
    walk.touched.clear();
    std::sort(across.begin(), across.end());
    std::vector<shader::VertexRun> runs;
    model::append_runs(across, runs);
    return runs;
  }

 private:
  static std::vector<BoundingBox> boxes_of(const std::vector<Vector3d>& places) {
    std::vector<BoundingBox> boxes;
    for (const Vector3d& p : places) boxes.push_back({p, p});
    return boxes;
  }

  // Dijkstra's algorithm from a vertex, until all requested vertices are reached or the rest is too far.
  void walk_along(std::uint32_t from, std::size_t asked, Walk& walk) const {
    using Waiting = std::pair<double, std::uint32_t>;
    std::priority_queue<Waiting, std::vector<Waiting>, std::greater<>> queue;
    const auto come_to = [&](std::uint32_t i, double way) {
      if (way >= walk.way[i] || way >= gap_detour * reach_) return;
      if (std::isinf(walk.way[i])) {
        walk.touched.push_back(i);
        asked -= walk.is_asked[i] != 0 ? 1U : 0U;
      }
      walk.way[i] = way;
      queue.emplace(way, i);
    };
    come_to(from, 0.0);
    while (!queue.empty() && asked > 0) {
      const auto [way, i] = queue.top();
      queue.pop();
      if (way > walk.way[i]) continue;
      for (std::uint32_t e = model_.ring_offset[i]; e < model_.ring_offset[i + 1]; ++e)
        come_to(model_.ring[e], way + (rest_[model_.ring[e]] - rest_[i]).norm());
    }
  }

  const Model& model_;
  const std::vector<Vector3d>& rest_;
  double reach_;
  BoxTree tree_;
};

// How deep a point lies at rest in flesh across a gap: in the first tetrahedron of such flesh that contains
// it.
class RestOverlap {
 public:
  RestOverlap(const Model& model, const std::vector<Vector3d>& rest)
      : model_(model), rest_(rest), tree_(boxes_of(model, rest)) {}

  // contact_near has the point's list.
  double depth(std::uint32_t p) const {
    const std::uint32_t vertex = model_.contact[p].vertex;
    std::optional<std::uint32_t> first;
    double depth = 0.0;
    tree_.visit_near(rest_[vertex], 0.0, [&](std::uint32_t t) {
      if ((first && *first < t) || model_.is_ignored_contact(p, t)) return 0.0;
      if (const std::optional<double> found = depth_in(t, p)) {
        first = t;
        depth = *found;
      }
      return 0.0;
    });
    return depth;
  }

 private:
  static std::vector<BoundingBox> boxes_of(const Model& model, const std::vector<Vector3d>& rest) {
    std::vector<BoundingBox> boxes;
    for (std::size_t t = 0; t < model.contact_tetrahedron.size(); t += 4) {
      const std::uint32_t* corner = model.contact_tetrahedron.data() + t;
      boxes.push_back(
          box_around(std::array{rest[corner[0]], rest[corner[1]], rest[corner[2]], rest[corner[3]]}));
    }
    return boxes;
  }

  std::optional<double> depth_in(std::uint32_t t, std::uint32_t p) const {
    const shader::ContactPoint& point = model_.contact[p];
    const std::uint32_t vertex = point.vertex;
    const std::uint32_t* corner = model_.contact_tetrahedron.data() + 4 * std::size_t{t};
    Eigen::Matrix3d edges;
    for (int k = 0; k < 3; ++k) edges.col(k) = rest_[corner[k + 1]] - rest_[corner[0]];
    const Vector3d in_edges = edges.inverse() * (rest_[vertex] - rest_[corner[0]]);
    const std::array<double, 4> weights{1.0 - in_edges.sum(), in_edges[0], in_edges[1], in_edges[2]};
    double depth = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
      if (weights[k] < 0.0 || !model::is_across_a_gap(model_, point, corner[k])) return std::nullopt;
      depth += weights[k] * double{model::contact_depth_of(model_, p, corner[k])};
    }
    return depth;
  }

  const Model& model_;
  const std::vector<Vector3d>& rest_;
  BoxTree tree_;
};

// Each point's list across gaps, and its depth at rest in the flesh there.
void write_gaps(const std::vector<Vector3d>& rest, double margin, Model& model) {
  const GapSearch search(model, rest, gap_margins * margin);
  std::vector<std::vector<shader::VertexRun>> near(model.contact.size());
  std::vector<GapSearch::Walk> walks(base::thread_count());
  base::for_each_in_parallel(near.size(), walks.size(), [&](std::size_t p, std::size_t worker) {
    near[p] = search.across_from(model.contact[p].vertex, walks[worker]);
  });
  const RestOverlap overlap(model, rest);
  for (std::size_t p = 0; p < near.size(); ++p) {
    shader::ContactPoint& point = model.contact[p];
    point.first_near = static_cast<std::uint32_t>(model.contact_near.size());
    point.near_count = static_cast<std::uint32_t>(near[p].size());
    model.contact_near.insert(model.contact_near.end(), near[p].begin(), near[p].end());
    near[p] = std::vector<shader::VertexRun>();  // gives its memory back
    if (point.near_count > 0)
      point.allowance = model::as_factor(overlap.depth(static_cast<std::uint32_t>(p)));
  }
}

}  // namespace

void write_contact(const scene::ContactSettings& settings, const std::string& source, Model& model,
                   const ContactGroups& groups) {
  if (!(settings.self || groups.meets_others_only) || model.tetrahedron.empty()) return;
  bool can_move = false;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) can_move = can_move || !model.is_kinematic(i);
  if (!can_move) return;

  const std::vector<Vector3d> rest = rest_places(model);
  const std::vector<Triangle> triangles = boundary_triangles(model, source);
  std::vector<char> is_point(model.vertex_count, 0);
  for (const Triangle& t : triangles)
    for (const std::uint32_t i : t) is_point[i] = 1;
  const double margin = margin_of(settings, rest, mean_edge(triangles, rest), source, model.unit);

  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    if (meets_nothing(groups, i)) is_point[i] = 0;
  const std::vector<std::uint32_t> tetrahedra = ordered_tetrahedra(model, rest, groups);
  if (tetrahedra.empty() || std::none_of(is_point.begin(), is_point.end(), [](char is) { return is != 0; })) {
    if (!settings.self) return;
    fail(source,
         "contact: no flesh is left that could meet other flesh; remove some exclusions (contact.ignore, "
         "contact.attribute, contact = false of layers), or set contact.self = false");
  }

  model.contact_tetrahedron = tetrahedra;
  const auto is_met = [](std::size_t) { return true; };
  model.contact_depth = depths(
      tetrahedra.size() < model.tetrahedron.size() ? boundary_of_met(model, rest, source, is_met) : triangles,
      rest);
  model.contact_number.assign(model.vertex_count, shader::no_contact);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    if (is_point[i] == 0) continue;
    model.contact_number[i] = static_cast<std::uint32_t>(model.contact.size());
    model.contact.push_back({.vertex = i,
                             .margin = static_cast<float>(margin),
                             .allowance = 0.0f,
                             .friction = model::as_factor(settings.friction),
                             .first_near = 0,
                             .near_count = 0});
  }
  write_groups(groups, model);
  if (groups.meets_others_only && !can_meet(model)) return take_contact_away(model);
  write_group_depths(rest, source, model);
  write_entries(model);
  write_rest_boxes(model);
  write_gaps(rest, margin, model);
  write_mobility(model);
}

}  // namespace fascicle::build
