// Finds pairs of intersecting triangles with exact predicates, after a sweep of bounding boxes.
#include <algorithm>
#include <iterator>
#include <vector>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>
#include <CGAL/intersections.h>

#include "host/mesher/surface_report.h"

namespace fascicle::mesher {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Corner = Kernel::Point_3;

struct Triangle {
  std::array<int, 3> corner;
  std::array<Corner, 3> place;

  Kernel::Triangle_3 whole() const { return {place[0], place[1], place[2]}; }
  // The side opposite corner k.
  Kernel::Segment_3 side(std::size_t k) const { return {place[(k + 1) % 3], place[(k + 2) % 3]}; }
};

// Corners that both triangles have, as pairs of positions in them.
std::vector<std::array<std::size_t, 2>> shared_corners(const Triangle& a, const Triangle& b) {
  std::vector<std::array<std::size_t, 2>> shared;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      if (a.corner[i] == b.corner[j]) shared.push_back({i, j});
  return shared;
}

bool cross(const Triangle& a, const Triangle& b) {
  const auto shared = shared_corners(a, b);
  if (shared.empty()) return CGAL::do_intersect(a.whole(), b.whole());
  if (shared.size() == 1)
    return CGAL::do_intersect(a.side(shared[0][0]), b.whole()) ||
           CGAL::do_intersect(b.side(shared[0][1]), a.whole());
  if (shared.size() == 2) {
    // Folded onto each other: coplanar, with their free corners on the same side of the shared edge.
    const std::size_t free_a = 3 - shared[0][0] - shared[1][0];
    const std::size_t free_b = 3 - shared[0][1] - shared[1][1];
    const Corner &p = a.place[shared[0][0]], &q = a.place[shared[1][0]];
    return CGAL::coplanar(p, q, a.place[free_a], b.place[free_b]) &&
           CGAL::coplanar_orientation(p, q, a.place[free_a], b.place[free_b]) == CGAL::POSITIVE;
  }
  return true;
}

}  // namespace

std::vector<std::array<int, 2>> intersecting_triangles(const Surface& surface, std::size_t most,
                                                       std::size_t& count) {
  using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, int>;
  std::vector<Triangle> triangles;
  std::vector<Box> boxes;
  triangles.reserve(surface.triangles.size());
  for (const auto& corners : surface.triangles) {
    Triangle triangle{corners, {}};
    for (std::size_t k = 0; k < 3; ++k) {
      const Point& p = surface.vertices[static_cast<std::size_t>(corners[k])];
      triangle.place[k] = Corner(p[0], p[1], p[2]);
    }
    // A degenerate triangle has no interior to cross; the report lists it separately.
    if (!CGAL::collinear(triangle.place[0], triangle.place[1], triangle.place[2]))
      boxes.emplace_back(triangle.whole().bbox(), static_cast<int>(triangles.size()));
    triangles.push_back(triangle);
  }
  std::vector<std::array<int, 2>> pairs;
  CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), [&](const Box& a, const Box& b) {
    if (cross(triangles[static_cast<std::size_t>(a.info())], triangles[static_cast<std::size_t>(b.info())]))
      pairs.push_back({std::min(a.info(), b.info()), std::max(a.info(), b.info())});
  });
  std::sort(pairs.begin(), pairs.end());
  count = pairs.size();
  if (pairs.size() > most) pairs.resize(most);
  return pairs;
}

}  // namespace fascicle::mesher
