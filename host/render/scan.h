// Which sample points a triangle covers, exactly: corners are rounded to a grid of 1/256 pixel and all tests
// are in integers, so that triangles that share a side neither both claim a point on it nor leave it out.
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

// Nothing for places so far off that products would not fit, and for what is not a number.
inline std::optional<GridPoint> to_grid(double x, double y) {
  constexpr double far = 1 << 20;
  if (!(std::fabs(x) < far && std::fabs(y) < far)) return std::nullopt;
  return GridPoint{std::llround(x * grid), std::llround(y * grid)};
}

// The three edge functions of a triangle. At a point inside each is >= 0, and together they are twice the
// area: the value of edge k over `area` is the barycentric coordinate of corner k.
struct Edges {
  std::array<std::int64_t, 3> dx, dy, constant;
  std::array<std::int64_t, 3>
      least;  // covered where value >= least: a side belongs to one of its two triangles
  std::int64_t area = 0;

  std::int64_t value(std::size_t k, std::int64_t x, std::int64_t y) const {
    return dx[k] * x + dy[k] * y + constant[k];
  }
  // Of a point whose values are already at hand.
  bool covers(std::int64_t e0, std::int64_t e1, std::int64_t e2) const {
    return e0 >= least[0] && e1 >= least[1] && e2 >= least[2];
  }
};

// Of either winding. Nothing for a triangle without area.
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
