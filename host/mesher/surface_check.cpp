#include "host/mesher/surface_check.h"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <vector>

#include "host/mesher/exit_codes.h"

namespace fascicle::mesher {
namespace {

struct HalfEdge {
  int low = 0, high = 0;
  bool is_forward = false;  // its triangle traverses it from low to high
};

void check_triangles(const Surface& surface) {
  std::vector<bool> is_used(surface.vertices.size(), false);
  for (std::size_t i = 0; i < surface.triangles.size(); ++i) {
    const auto& t = surface.triangles[i];
    const auto vertex = [&](std::size_t k) { return surface.vertices[static_cast<std::size_t>(t[k])]; };
    if (!has_area(vertex(0), vertex(1), vertex(2))) {
      throw Failure(not_closed, "triangle " + std::to_string(i) + " has no area");
    }
    for (const int v : t) is_used[static_cast<std::size_t>(v)] = true;
  }
  const auto unused = std::find(is_used.begin(), is_used.end(), false);
  if (unused != is_used.end()) {
    throw Failure(not_closed,
                  "vertex " + std::to_string(unused - is_used.begin()) + " belongs to no triangle");
  }
}

void check_places(const Surface& surface) {
  std::vector<int> order(surface.vertices.size());
  std::iota(order.begin(), order.end(), 0);
  const auto place = [&](int i) { return surface.vertices[static_cast<std::size_t>(i)]; };
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return std::tuple(place(a), a) < std::tuple(place(b), b); });
  const auto twice =
      std::adjacent_find(order.begin(), order.end(), [&](int a, int b) { return place(a) == place(b); });
  if (twice != order.end()) {
    throw Failure(not_closed, "vertices " + std::to_string(*twice) + " and " + std::to_string(*(twice + 1)) +
                                  " lie at one place");
  }
}

void check_edges(const Surface& surface) {
  std::vector<HalfEdge> edges;
  edges.reserve(3 * surface.triangles.size());
  for (const auto& t : surface.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int from = t[k];
      const int to = t[(k + 1) % 3];
      edges.push_back({std::min(from, to), std::max(from, to), from < to});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return std::tuple(a.low, a.high) < std::tuple(b.low, b.high);
  });
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i;
    while (end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high) ++end;
    const std::string edge =
        "the edge of vertices " + std::to_string(edges[i].low) + " and " + std::to_string(edges[i].high);
    if (end - i == 1) throw Failure(not_closed, edge + " has only one triangle");
    if (end - i > 2) throw Failure(not_closed, edge + " has " + std::to_string(end - i) + " triangles");
    if (edges[i].is_forward == edges[i + 1].is_forward) {
      throw Failure(not_closed, edge + " has two triangles that face opposite ways");
    }
    i = end;
  }
}

}  // namespace

bool has_area(const Point& a, const Point& b, const Point& c) {
  const auto cross_part = [&](std::size_t i, std::size_t j) {
    return (b[i] - a[i]) * (c[j] - a[j]) - (b[j] - a[j]) * (c[i] - a[i]);
  };
  return cross_part(0, 1) != 0.0 || cross_part(1, 2) != 0.0 || cross_part(2, 0) != 0.0;
}

void check_closed(const Surface& surface) {
  check_places(surface);
  check_triangles(surface);
  check_edges(surface);
}

}  // namespace fascicle::mesher
