#include "cpu_reference/oracle/oracle_equations.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/LU>
#include <Eigen/SVD>

namespace fascicle::cpu_reference {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

// (8) c_r = sum w_ir q_i / sum w_ir
Vector3d region_centre(const Weights& weights, std::uint32_t r, const Points& points) {
  Vector3d sum = Vector3d::Zero();
  double W = 0.0;
  for (Eigen::SparseMatrix<double>::InnerIterator w(weights.of_region, int(r)); w; ++w) {
    sum += w.value() * points[std::size_t(w.row())];
    W += w.value();
  }
  return W > 0.0 ? Vector3d(sum / W) : points[r];
}

Matrix3d region_moment(const Weights& weights, std::uint32_t r, const Matrix3d& T, const Points& rest,
                       const Vector3d& c0, const Points& positions, const Vector3d& c) {
  Matrix3d A = Matrix3d::Zero();
  for (Eigen::SparseMatrix<double>::InnerIterator w(weights.of_region, int(r)); w; ++w) {
    const auto i = std::size_t(w.row());
    A += w.value() * (positions[i] - c) * (T * (rest[i] - c0)).transpose();
  }
  return A;
}

// With A = U S V^T, four rotations are special: U diag(e) V^T with one of the sign patterns e below, where d
// = det(U) det(V) makes the determinant +1. They are the stationary points of trace(R^T A), which is s1 e1 +
// s2 e2 + s3 e3 there, so the first is the best. If others reach the same trace, the best rotations are all
// those whose quaternions lie in the span of the tied ones' quaternions (which are mutually orthogonal), and
// the one nearest to the previous rotation is its projection onto that span. So a moment of rank one fixes an
// axis and keeps the twist, and a zero moment keeps the rotation.
Quaterniond best_rotation(const Matrix3d& A, const Quaterniond& previous) {
  const Eigen::JacobiSVD<Matrix3d> svd(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Matrix3d& U = svd.matrixU();
  const Matrix3d& V = svd.matrixV();
  const Vector3d& s = svd.singularValues();
  const double d = U.determinant() * V.determinant() < 0.0 ? -1.0 : 1.0;
  const std::array<Vector3d, 4> signs{Vector3d(1, 1, d), Vector3d(1, -1, -d), Vector3d(-1, 1, -d),
                                      Vector3d(-1, -1, d)};
  // Sums of some 20 terms leave the singular values uncertain by about 2^-48 of the largest; smaller gaps
  // count as ties.
  const double best = s.dot(signs[0]);
  const double tie = std::ldexp(s[0], -40);

  Eigen::Vector4d nearest = Eigen::Vector4d::Zero();
  for (const Vector3d& e : signs) {
    if (s.dot(e) < best - tie) continue;
    const Quaterniond candidate(Matrix3d(U * e.asDiagonal() * V.transpose()));
    nearest += candidate.coeffs().dot(previous.coeffs()) * candidate.coeffs();
  }
  // If the previous rotation is half a turn from every best rotation, none is nearest and any will do.
  if (nearest.norm() < 1e-6)
    return Quaterniond(Matrix3d(U * signs[0].asDiagonal() * V.transpose())).normalized();
  return Quaterniond(nearest).normalized();
}

// (10) g_i^r = R_r T_r (q0_i - c0_r) + c_r
Vector3d region_goal(const Matrix3d& R, const Matrix3d& T, const Vector3d& rest, const Vector3d& c0,
                     const Vector3d& c) {
  return R * T * (rest - c0) + c;
}

// (11) g_i = sum_{r: i in N_r} w_ir g_i^r / sum_{r: i in N_r} w_ir
Vector3d blended_goal(const Weights& weights, std::uint32_t i, const std::vector<RegionPose>& regions,
                      const Points& rest, const Points& positions) {
  Vector3d sum = Vector3d::Zero();
  double W = 0.0;
  for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator w(weights.of_vertex, int(i)); w; ++w) {
    const RegionPose& region = regions[std::size_t(w.col())];
    sum += w.value() * (region_goal(region.R.toRotationMatrix(), region.T, rest[i], region.c0, region.c) +
                        region.V * (rest[i] - region.c0));
    W += w.value();
  }
  return W > 0.0 ? Vector3d(sum / W) : positions[i];
}

Matrix3d volume_push(const Matrix3d& A, const Matrix3d& A0, double G) {
  const double size = std::cbrt(A0.determinant());
  const Matrix3d inverse = (A0 / size).inverse();
  const Matrix3d a = A / size;
  Matrix3d C;
  for (int k = 0; k < 3; ++k) C.col(k) = a.col((k + 1) % 3).cross(a.col((k + 2) % 3));
  const double x = 1.0 - a.determinant();
  const double bounded = x / (1.0 + std::abs(x)) * std::min(1.0, inverse.squaredNorm() / C.squaredNorm());
  return G / inverse.trace() * bounded * C;
}

// (4) v_i <- v_i + h f_i/m_i + alpha (g_i - q_i)/h; the two terms are separate stages
Vector3d velocity_with_forces(const Vector3d& v, const Vector3d& acceleration, double h) {
  return v + h * acceleration;
}

Vector3d velocity_to_goal(const Vector3d& v, double alpha, const Vector3d& goal, const Vector3d& q,
                          double h) {
  return v + alpha * (goal - q) / h;
}

Vector3d damped_velocity(const Vector3d& v, const Vector3d& u, double decay) {
  return u + (v - u) * decay;
}

// (5) q_i <- q_i + h v_i
Vector3d moved_position(const Vector3d& q, const Vector3d& v, double h) {
  return q + h * v;
}

// (17) c = 1 + gain beta_r sin(theta) (n_r . tau), clamped to [0.25, 4]
double muscle_stretch(double bulge) {
  return std::clamp(1.0 + bulge, 0.25, 4.0);
}

// (15) T_r = D M D^T with D = [d1 d2 d3] orthonormal, d1 = n_r
// (16) M = diag(c, 1/sqrt(c), 1/sqrt(c)), whose determinant is 1
Matrix3d muscle_scale(const Vector3d& n, double c) {
  if (n.isZero(0.0)) return Matrix3d::Identity();
  Matrix3d D;
  D.col(0) = n;
  D.col(1) = n.unitOrthogonal();
  D.col(2) = D.col(0).cross(D.col(1));
  const Vector3d M(c, 1.0 / std::sqrt(c), 1.0 / std::sqrt(c));
  return D * M.asDiagonal() * D.transpose();
}

Matrix3d muscle_twist(const Vector3d& axis, const Vector3d& around, double shear) {
  return Matrix3d::Identity() + shear * around * axis.transpose();
}

}  // namespace fascicle::cpu_reference
