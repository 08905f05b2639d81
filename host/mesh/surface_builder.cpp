#include "host/mesh/surface_builder.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>

namespace fascicle::mesh {
namespace {

using Triangle = std::array<std::uint32_t, 3>;
using Point2 = std::array<double, 2>;

// The sum over a fan, twice the polygon's area in length: Newell's normal.
Vector3d newell_normal(const std::vector<Vector3d>& vertices, const std::vector<std::uint32_t>& polygon) {
  const Vector3d& first = vertices[polygon[0]];
  Vector3d normal = Vector3d::Zero();
  for (std::size_t k = 1; k + 1 < polygon.size(); ++k)
    normal += (vertices[polygon[k]] - first).cross(vertices[polygon[k + 1]] - first);
  return normal;
}

// Twice the area, positive counterclockwise.
double turn(const Point2& a, const Point2& b, const Point2& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

double squared_distance(const Point2& a, const Point2& b) {
  return (b[0] - a[0]) * (b[0] - a[0]) + (b[1] - a[1]) * (b[1] - a[1]);
}

// What is left of a polygon while its ears are cut off, in the plane it is nearest to.
class Rest {
 public:
  Rest(const std::vector<Vector3d>& vertices, std::vector<std::uint32_t> polygon)
      : polygon_(std::move(polygon)) {
    constexpr double rounding = 1e-12;
    const Vector3d normal = newell_normal(vertices, polygon_);
    Eigen::Index left_out = 0;
    normal.cwiseAbs().maxCoeff(&left_out);
    const Eigen::Index x = (left_out + 1) % 3, y = (left_out + 2) % 3;
    const double side = normal[left_out] < 0.0 ? -1.0 : 1.0;
    for (const std::uint32_t v : polygon_) at_.push_back({side * vertices[v][x], vertices[v][y]});
    flat_ = rounding * std::abs(normal[left_out]);
    for (std::size_t k = 0; k < polygon_.size(); ++k) {
      before_.push_back(k == 0 ? polygon_.size() - 1 : k - 1);
      after_.push_back(k + 1 == polygon_.size() ? 0 : k + 1);
    }
    is_left_.assign(polygon_.size(), 1);
    fitness_.resize(polygon_.size());
    for (std::size_t k = 0; k < polygon_.size(); ++k) fitness_[k] = fitness_of(k);
  }

  std::vector<Triangle> triangles() {
    std::vector<Triangle> triangles;
    std::size_t count = polygon_.size(), last = 0;
    for (; count > 3; --count) {
      const auto best = std::max_element(fitness_.begin(), fitness_.end());
      if (!(*best > 0.0)) break;
      const auto ear = static_cast<std::size_t>(best - fitness_.begin());
      triangles.push_back(corners_at(ear));
      last = before_[ear];
      after_[last] = after_[ear];
      before_[after_[ear]] = last;
      is_left_[ear] = 0;
      fitness_[ear] = 0.0;
      fitness_[last] = fitness_of(last);
      fitness_[after_[last]] = fitness_of(after_[last]);
    }
    for (std::size_t k = after_[last]; after_[k] != last; k = after_[k])
      triangles.push_back({polygon_[last], polygon_[k], polygon_[after_[k]]});
    return triangles;
  }

 private:
  Triangle corners_at(std::size_t k) const {
    return {polygon_[before_[k]], polygon_[k], polygon_[after_[k]]};
  }

  // The roundness of the triangle at a corner if it is an ear: convex, with nothing else of the polygon
  // inside or on its sides. Otherwise 0. Flat ears are cut off last.
  double fitness_of(std::size_t k) const {
    const Triangle t = corners_at(k);
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return 0.0;
    const Point2 &a = at_[before_[k]], &b = at_[k], &c = at_[after_[k]];
    const double area = turn(a, b, c);
    if (!(area > flat_)) return 0.0;
    for (std::size_t other = 0; other < polygon_.size(); ++other) {
      const Point2& p = at_[other];
      if (is_left_[other] == 0 || p == a || p == b || p == c) continue;
      // Whatever reaches into an ear has a corner there that is not convex.
      if (turn(at_[before_[other]], p, at_[after_[other]]) > flat_) continue;
      if (turn(a, b, p) >= -flat_ && turn(b, c, p) >= -flat_ && turn(c, a, p) >= -flat_) return 0.0;
    }
    return area / std::max({squared_distance(a, b), squared_distance(b, c), squared_distance(c, a)});
  }

  std::vector<std::uint32_t> polygon_;
  std::vector<Point2> at_;
  double flat_ = 0.0;  // twice the area of a triangle that is one only by rounding
  std::vector<std::size_t> before_, after_;
  std::vector<char> is_left_;
  std::vector<double> fitness_;
};

}  // namespace

bool is_covered_by_fan(const std::vector<Vector3d>& vertices, const std::vector<std::uint32_t>& polygon) {
  // Corners on a line, in single precision, turn over less than this share of the polygon.
  constexpr double rounding = 1e-6;
  const Vector3d normal = newell_normal(vertices, polygon);
  const double limit = -rounding * normal.squaredNorm();
  const Vector3d& first = vertices[polygon[0]];
  for (std::size_t k = 1; k + 1 < polygon.size(); ++k)
    if ((vertices[polygon[k]] - first).cross(vertices[polygon[k + 1]] - first).dot(normal) < limit)
      return false;
  return true;
}

std::vector<Triangle> cut_into_ears(const std::vector<Vector3d>& vertices,
                                    std::vector<std::uint32_t> polygon) {
  return Rest(vertices, std::move(polygon)).triangles();
}

std::size_t drop_repeated_corners(std::vector<std::uint32_t>& polygon) {
  const std::size_t before = polygon.size();
  polygon.erase(std::unique(polygon.begin(), polygon.end()), polygon.end());
  while (polygon.size() > 1 && polygon.back() == polygon.front()) polygon.pop_back();
  return before - polygon.size();
}

}  // namespace fascicle::mesh
