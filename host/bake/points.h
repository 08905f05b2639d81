// Points and vectors for measurements, in double.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace fascicle::bake {

using Point = std::array<double, 3>;

// From an array of 3 values per vertex.
inline Point point_at(const std::vector<float>& values, std::size_t i) {
  return {double{values[3 * i]}, double{values[3 * i + 1]}, double{values[3 * i + 2]}};
}

inline Point difference(const Point& a, const Point& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

inline double dot(const Point& a, const Point& b) {
  return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
}

inline Point cross_product(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

inline double length(const Point& a) {
  return std::sqrt(dot(a, a));
}

// Of three columns or rows; six times the volume of a tetrahedron with these edges.
inline double determinant(const Point& a, const Point& b, const Point& c) {
  return dot(a, cross_product(b, c));
}

}  // namespace fascicle::bake
