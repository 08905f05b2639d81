#include "host/model/rotation.h"

#include <cmath>
#include <cstddef>

namespace fascicle::model {

namespace {

double determinant(const Matrix3& m) {
  return m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) +
         m[2] * (m[3] * m[7] - m[4] * m[6]);
}

Quaternion normalized(Quaternion q) {
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (double& c : q) c /= length;
  return q;
}

}  // namespace

Matrix3 multiply(const Matrix3& a, const Matrix3& b) {
  Matrix3 m{};
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t c = 0; c < 3; ++c)
      m[3 * row + c] = a[3 * row] * b[c] + a[3 * row + 1] * b[3 + c] + a[3 * row + 2] * b[6 + c];
  return m;
}

Matrix3 transposed(const Matrix3& m) {
  return {m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]};
}

std::array<double, 3> multiply(const Matrix3& m, const std::array<double, 3>& v) {
  std::array<double, 3> r{};
  for (std::size_t row = 0; row < 3; ++row)
    r[row] = m[3 * row] * v[0] + m[3 * row + 1] * v[1] + m[3 * row + 2] * v[2];
  return r;
}

// Newton's iteration for the polar factor, R <- (R + R^-T)/2 (Higham 1986).
Matrix3 nearest_rotation(Matrix3 m) {
  const Matrix3 identity{1, 0, 0, 0, 1, 0, 0, 0, 1};
  for (int step = 0; step < 40; ++step) {
    const double d = determinant(m);
    if (!(d > 1e-12)) return identity;
    const Matrix3 cofactor{m[4] * m[8] - m[5] * m[7], m[5] * m[6] - m[3] * m[8], m[3] * m[7] - m[4] * m[6],
                           m[2] * m[7] - m[1] * m[8], m[0] * m[8] - m[2] * m[6], m[1] * m[6] - m[0] * m[7],
                           m[1] * m[5] - m[2] * m[4], m[2] * m[3] - m[0] * m[5], m[0] * m[4] - m[1] * m[3]};
    double change = 0.0;
    for (std::size_t k = 0; k < 9; ++k) {
      const double next = 0.5 * (m[k] + cofactor[k] / d);
      change += std::abs(next - m[k]);
      m[k] = next;
    }
    if (change < 1e-15) break;
  }
  return m;
}

// By the largest component (Shepperd 1978).
Quaternion quaternion_of(const Matrix3& r) {
  const double trace = r[0] + r[4] + r[8];
  if (trace >= r[0] && trace >= r[4] && trace >= r[8])
    return normalized({1.0 + trace, r[7] - r[5], r[2] - r[6], r[3] - r[1]});
  if (r[0] >= r[4] && r[0] >= r[8])
    return normalized({r[7] - r[5], 1.0 + r[0] - r[4] - r[8], r[1] + r[3], r[2] + r[6]});
  if (r[4] >= r[8]) return normalized({r[2] - r[6], r[1] + r[3], 1.0 + r[4] - r[0] - r[8], r[5] + r[7]});
  return normalized({r[3] - r[1], r[2] + r[6], r[5] + r[7], 1.0 + r[8] - r[0] - r[4]});
}

Quaternion multiply(const Quaternion& a, const Quaternion& b) {
  return normalized({a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
                     a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
                     a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
                     a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]});
}

}  // namespace fascicle::model
