// Which sample points a triangle covers, exactly: corners are rounded to a grid of 1/256 pixel and all tests
// use integers, so that triangles that share an edge neither both cover a point on it nor leave a gap.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <optional>

namespace fascicle::render {

inline constexpr int grid_bits = 8;
inline constexpr std::int64_t grid = std::int64_t{1} << grid_bits;

struct GridPoint {
  std::int64_t x = 0, y = 0;  // 1/256 pixel
};

// Pixels; beyond them products would overflow.
inline constexpr double farthest_place = 1 << 20;

// Nothing for NaN and for points too far away.
inline std::optional<GridPoint> to_grid(double x, double y) {
  if (!(std::fabs(x) < farthest_place && std::fabs(y) < farthest_place)) return std::nullopt;
  return GridPoint{std::llround(x * grid), std::llround(y * grid)};
}

// The three edge functions of a triangle. At a point inside, each is >= 0 and they sum to twice the area: the
// value of edge k over `area` is the barycentric coordinate of corner k.
struct Edges {
  std::array<std::int64_t, 3> dx, dy, constant;
  std::array<std::int64_t, 3>
      least;  // covered if value >= least: an edge belongs to one of its two triangles
  std::int64_t area = 0;

  std::int64_t value(std::size_t k, std::int64_t x, std::int64_t y) const {
    return dx[k] * x + dy[k] * y + constant[k];
  }
  // For a point whose values are already known.
  bool covers(std::int64_t e0, std::int64_t e1, std::int64_t e2) const {
    return e0 >= least[0] && e1 >= least[1] && e2 >= least[2];
  }
};

// Either winding. Nothing for a degenerate triangle.
inline std::optional<Edges> edges_of(const std::array<GridPoint, 3>& corners) {
  Edges edges;
  const auto& [a, b, c] = corners;
  edges.area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  if (edges.area == 0) return std::nullopt;
  const std::int64_t sign = edges.area > 0 ? 1 : -1;
  edges.area *= sign;
  for (std::size_t k = 0; k < 3; ++k) {
    const GridPoint from = corners[(k + 1) % 3], to = corners[(k + 2) % 3];
    edges.dx[k] = -sign * (to.y - from.y);
    edges.dy[k] = sign * (to.x - from.x);
    edges.constant[k] = -(edges.dx[k] * from.x + edges.dy[k] * from.y);
    const bool owns = edges.dx[k] > 0 || (edges.dx[k] == 0 && edges.dy[k] > 0);
    edges.least[k] = owns ? 0 : 1;
  }
  return edges;
}

}  // namespace fascicle::render
