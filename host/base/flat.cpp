#include "host/base/flat.h"

#include <algorithm>
#include <cmath>

namespace fascicle::base {

namespace {

using Vector = std::array<double, 3>;

constexpr double flat_share = 0.02, least_width = 0.1;

Vector difference(const Vector& a, const Vector& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
double dot(const Vector& a, const Vector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

}  // namespace

bool is_flat(std::span<const Vector> points) {
  if (points.empty()) return false;
  Vector origin = points.front();
  // From the origin to the point with the largest `distance`.
  const auto farthest = [&](auto distance) {
    const auto nearer = [&](const Vector& a, const Vector& b) {
      return distance(difference(a, origin)) < distance(difference(b, origin));
    };
    return difference(*std::max_element(points.begin(), points.end(), nearer), origin);
  };
  const auto squared = [](const Vector& v) { return dot(v, v); };
  // An end, whichever point comes first.
  const Vector end = farthest(squared);
  for (std::size_t a = 0; a < 3; ++a) origin[a] += end[a];
  const Vector along = farthest(squared);
  const Vector aside = farthest([&](const Vector& d) { return squared(cross(along, d)); });
  const Vector normal = cross(along, aside);
  const double area = std::sqrt(squared(normal)), length = std::sqrt(squared(along));
  if (!(area >= least_width * length * length) || !(area > 0.0)) return false;
  const Vector out = farthest([&](const Vector& d) { return std::abs(dot(normal, d)); });
  return std::abs(dot(normal, out)) <= flat_share * length * area;
}

}  // namespace fascicle::base
