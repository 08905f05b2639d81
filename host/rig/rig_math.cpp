#include "host/rig/rig_math.h"

#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace fascicle::rig {
namespace {

// Relative to the matrix's size: its determinant over the cube of its norm.
constexpr double flat = 1e-6;
// Almost opposite directions have no unique shortest rotation: v is negated.
constexpr double opposite = -0.999;

}  // namespace

JointParts joint_parts(const Eigen::Matrix4d& local) {
  JointParts parts{.translation = local.topRightCorner<3, 1>(), .scale = Vector3d::Zero(), .rotation = {}};
  Eigen::Matrix3d rotation = local.topLeftCorner<3, 3>();
  const bool mirrors = rotation.determinant() < 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double length = rotation.col(axis).norm();
    parts.scale[axis] = mirrors && axis == 0 ? -length : length;
    if (length > 0.0) rotation.col(axis) /= parts.scale[axis];
  }
  parts.rotation = Eigen::Quaterniond(rotation).normalized().coeffs();
  return parts;
}

Vector3d solve(const Eigen::Matrix3d& linear, const Vector3d& y) {
  const double size = linear.norm();
  if (std::abs(linear.determinant()) > flat * size * size * size) return linear.inverse() * y;
  const Eigen::Matrix3d damped =
      linear * linear.transpose() + (flat * size * size + 1e-30) * Eigen::Matrix3d::Identity();
  return linear.transpose() * (damped.inverse() * y);
}

Eigen::Matrix4d affine_inverse(const Eigen::Matrix4d& m) {
  Eigen::Matrix4d result = Eigen::Matrix4d::Identity();
  const Eigen::Matrix3d linear = m.topLeftCorner<3, 3>().inverse();
  result.topLeftCorner<3, 3>() = linear;
  result.topRightCorner<3, 1>() = -(linear * m.topRightCorner<3, 1>());
  return result;
}

Vector3d turn(const Vector3d& v, const Vector3d& a, const Vector3d& b) {
  const Vector3d axis = a.cross(b);
  const double cosine = a.dot(b);
  if (cosine < opposite) return -v;
  return v + axis.cross(v) + axis.cross(axis.cross(v)) / (1.0 + cosine);
}

}  // namespace fascicle::rig
