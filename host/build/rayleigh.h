// Common steps of minimising a Rayleigh quotient x.Lx / x.Mx along conjugate directions, on a body and on a
// grid.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <Eigen/Core>

namespace fascicle::build {

// In a fixed order, unlike Eigen's.
inline double scalar_product(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// t that minimises (a11 + 2 a12 t + a22 t^2)/(m11 + 2 m12 t + m22 t^2).
inline double best_step(double a11, double a12, double a22, double m11, double m12, double m22) {
  const double a = a22 * m12 - a12 * m22, b = a22 * m11 - a11 * m22, c = a12 * m11 - a11 * m12;
  const double root = std::sqrt(std::max(0.0, b * b - 4.0 * a * c));
  const double t = -2.0 * c / (b + root);
  return std::isfinite(t) ? t : 0.0;
}

// Pseudorandom numbers from -1 to 1.
class Noise {
 public:
  double next() {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return static_cast<double>(state_ >> 33) / 1073741824.0 - 1.0;
  }

 private:
  std::uint64_t state_ = 1;
};

}  // namespace fascicle::build
