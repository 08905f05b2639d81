#include "host/build/weld.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include <Eigen/Geometry>

#include "host/build/box_tree.h"
#include "host/build/message.h"

namespace fascicle::build {

namespace {

using mesh::SurfaceMesh;
using scene::Vector3d;

constexpr double weld_of_diagonal = 1e-9;
// A cell is many tolerances wide, so that a vertex rarely has to check a second one.
constexpr double cell_in_tolerances = 1024.0;

// Of a coordinate, so that squares of lengths stay finite.
constexpr double farthest = 1e100;

void check_surface(const SurfaceMesh& surface, const std::string& source) {
  if (surface.triangles.empty()) fail(source, "mesh: there are no triangles");
  std::vector<std::uint32_t> bad;
  for (std::uint32_t i = 0; i < surface.vertices.size(); ++i)
    if (!surface.vertices[i].allFinite()) bad.push_back(i);
  if (!bad.empty())
    fail(source, "mesh: coordinates are not finite at vertex " + list_of(bad) + " (counted from 0)");
  for (std::uint32_t i = 0; i < surface.vertices.size(); ++i)
    if (surface.vertices[i].cwiseAbs().maxCoeff() > farthest) bad.push_back(i);
  if (!bad.empty())
    fail(source, "mesh: coordinates are beyond 1e100 or -1e100 at vertex " + list_of(bad) +
                     " (counted from 0); scale it");
  for (std::uint32_t k = 0; k < surface.triangles.size(); ++k)
    for (const std::uint32_t corner : surface.triangles[k])
      if (corner >= surface.vertices.size()) bad.push_back(k);
  if (!bad.empty())
    fail(source, "mesh: corner numbers must be below " + std::to_string(surface.vertices.size()) +
                     ", the number of vertices, but are not in triangle " + list_of(bad) +
                     " (counted from 0)");
}

using Cell = std::array<std::int64_t, 3>;

struct CellEntry {
  Cell cell;
  std::uint32_t vertex;
  bool operator<(const CellEntry& other) const {
    return cell != other.cell ? cell < other.cell : vertex < other.vertex;
  }
};

// Finds nearby vertices through a grid kept as a sorted list.
class NearbyVertices {
 public:
  // Those vertices that are their own `first`. The grid begins at `low`.
  NearbyVertices(const std::vector<Vector3d>& vertices, const std::vector<std::uint32_t>& first,
                 const Vector3d& low, double tolerance)
      : vertices_(vertices), tolerance_(tolerance), low_(low) {
    for (std::uint32_t i = 0; i < vertices.size(); ++i)
      if (first[i] == i) entries_.push_back({cell_of(vertices[i]), i});
    std::sort(entries_.begin(), entries_.end());
  }

  // Calls visit(j) for each vertex within the tolerance of vertex i, i itself included.
  template <class Visit>
  void for_each(std::uint32_t i, Visit visit) const {
    const Vector3d& p = vertices_[i];
    const Cell first = cell_of(p - Vector3d::Constant(tolerance_));
    const Cell last = cell_of(p + Vector3d::Constant(tolerance_));
    for (std::int64_t x = first[0]; x <= last[0]; ++x)
      for (std::int64_t y = first[1]; y <= last[1]; ++y)
        for (std::int64_t z = first[2]; z <= last[2]; ++z) {
          const Cell cell{x, y, z};
          auto entry = std::lower_bound(entries_.begin(), entries_.end(), CellEntry{cell, 0});
          for (; entry != entries_.end() && entry->cell == cell; ++entry)
            if ((vertices_[entry->vertex] - p).norm() <= tolerance_) visit(entry->vertex);
        }
  }

 private:
  Cell cell_of(const Vector3d& p) const {
    const double width = tolerance_ > 0.0 ? tolerance_ * cell_in_tolerances : 1.0;
    // Where cells have no numbers any more, the last one has all vertices.
    constexpr double last = 4e18;
    const Vector3d cell = ((p - low_) / width).cwiseMin(last).cwiseMax(-last);
    return {static_cast<std::int64_t>(std::floor(cell[0])), static_cast<std::int64_t>(std::floor(cell[1])),
            static_cast<std::int64_t>(std::floor(cell[2]))};
  }

  const std::vector<Vector3d>& vertices_;
  double tolerance_;
  Vector3d low_;
  std::vector<CellEntry> entries_;
};

// A vertex that belongs to no triangle may lie anywhere.
Eigen::AlignedBox3d box_of_triangles(const SurfaceMesh& surface) {
  Eigen::AlignedBox3d box;
  for (const auto& triangle : surface.triangles)
    for (const std::uint32_t corner : triangle) box.extend(surface.vertices[corner]);
  return box;
}

// For each vertex the lowest one at exactly its place.
std::vector<std::uint32_t> firsts_at_places(const std::vector<Vector3d>& vertices) {
  std::vector<std::uint32_t> order(vertices.size()), first(vertices.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto place = [&](std::uint32_t i) {
    return std::array{vertices[i][0], vertices[i][1], vertices[i][2]};
  };
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(place(a), a) < std::pair(place(b), b);
  });
  for (std::size_t k = 0; k < order.size(); ++k)
    first[order[k]] = k > 0 && place(order[k]) == place(order[k - 1]) ? first[order[k - 1]] : order[k];
  return first;
}

// For each vertex the lowest vertex it coincides with.
std::vector<std::uint32_t> representatives(const SurfaceMesh& surface) {
  // Any number of vertices may lie in one place: only the first of them is compared with others.
  const std::vector<std::uint32_t> first = firsts_at_places(surface.vertices);
  const Eigen::AlignedBox3d box = box_of_triangles(surface);
  const NearbyVertices nearby(surface.vertices, first, box.min(), weld_of_diagonal * box.diagonal().norm());
  std::vector<std::uint32_t> same(surface.vertices.size());
  for (std::uint32_t i = 0; i < same.size(); ++i) {
    if (first[i] != i) {
      same[i] = same[first[i]];
      continue;
    }
    std::uint32_t lowest = i;
    nearby.for_each(i, [&](std::uint32_t j) { lowest = std::min(lowest, j); });
    same[i] = lowest == i ? i : same[lowest];
  }
  return same;
}

BoxTree tree_of(const std::vector<Vector3d>& points) {
  std::vector<BoundingBox> boxes;
  for (const Vector3d& p : points) boxes.push_back({p, p});
  return BoxTree(boxes);
}

// Of vertices at the same distance, the lowest.
std::uint32_t nearest_vertex(const std::vector<Vector3d>& vertices, const BoxTree& tree,
                             const Vector3d& point) {
  std::uint32_t nearest = 0;
  double smallest = std::numeric_limits<double>::infinity();
  tree.visit_near(point, smallest, [&](std::uint32_t i) {
    const double distance2 = (vertices[i] - point).squaredNorm();
    if (distance2 < smallest || (distance2 == smallest && i < nearest)) {
      smallest = distance2;
      nearest = i;
    }
    // The tree adds up a distance in its own order, and may round it up above this one.
    constexpr double slack = 1.0 + 1e-12;
    return slack * smallest;
  });
  return nearest;
}

// Whether every triangle is a line to rounding.
bool is_flat_to_lines(const SurfaceMesh& surface,
                      const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  constexpr double least_height = 1e-8;  // of its longest edge
  return std::all_of(triangles.begin(), triangles.end(), [&](const std::array<std::uint32_t, 3>& t) {
    const Vector3d u = surface.vertices[t[1]] - surface.vertices[t[0]];
    const Vector3d v = surface.vertices[t[2]] - surface.vertices[t[0]];
    const double longest = std::max({u.norm(), v.norm(), (u - v).norm()});
    return u.cross(v).norm() <= least_height * longest * longest;
  });
}

}  // namespace

WeldedSurface weld(const SurfaceMesh& surface, const std::string& source, Report& report) {
  check_surface(surface, source);
  const std::vector<std::uint32_t> same = representatives(surface);

  WeldedSurface welded;
  std::vector<char> used(surface.vertices.size(), 0);
  std::size_t collapsed = 0;
  for (std::array<std::uint32_t, 3> t : surface.triangles) {
    for (std::uint32_t& corner : t) corner = same[corner];
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
      ++collapsed;
      continue;
    }
    for (const std::uint32_t corner : t) used[corner] = 1;
    welded.surface.triangles.push_back(t);
  }
  if (welded.surface.triangles.empty())
    fail(source, "mesh: every triangle has two corners at the same place; check the export");
  if (is_flat_to_lines(surface, welded.surface.triangles))
    fail(source, "mesh: every triangle is flat to a line, which leaves no room for flesh; check the export");
  if (collapsed > 0)
    warn_of_flesh(report, counted(collapsed, "triangle has", "triangles have") +
                              " two corners at the same place and " + (collapsed == 1 ? "was" : "were") +
                              " left out of the body");

  if (surface.repeated_corners > 0)
    warn(report, counted(surface.repeated_corners, "corner of the file's faces repeats",
                         "corners of the file's faces repeat") +
                     " the one before " + (surface.repeated_corners == 1 ? "it and was" : "them and were") +
                     " left out");

  std::vector<std::uint32_t> number(surface.vertices.size(), 0);
  for (std::uint32_t i = 0; i < surface.vertices.size(); ++i)
    if (used[i]) {
      number[i] = static_cast<std::uint32_t>(welded.surface.vertices.size());
      welded.surface.vertices.push_back(surface.vertices[i]);
    }
  for (auto& t : welded.surface.triangles)
    for (std::uint32_t& corner : t) corner = number[corner];

  std::vector<std::uint32_t> stray;
  std::optional<BoxTree> tree;
  for (std::uint32_t i = 0; i < surface.vertices.size(); ++i) {
    if (used[same[i]]) {
      welded.of_vertex.push_back(number[same[i]]);
      continue;
    }
    if (!tree) tree = tree_of(welded.surface.vertices);
    welded.of_vertex.push_back(nearest_vertex(welded.surface.vertices, *tree, surface.vertices[i]));
    stray.push_back(i);
  }
  if (!stray.empty())
    warn(report, counted(stray.size(), "vertex of the surface belongs", "vertices of the surface belong") +
                     " to no triangle (vertex " + list_of(stray) +
                     "); each follows the nearest vertex that does");
  return welded;
}

double mean_edge(const SurfaceMesh& surface) {
  double sum = 0.0;
  for (const auto& t : surface.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      sum += (surface.vertices[t[k]] - surface.vertices[t[(k + 1) % 3]]).norm();
  return sum / (3.0 * static_cast<double>(surface.triangles.size()));
}

}  // namespace fascicle::build
