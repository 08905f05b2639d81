// Linear algebra for moving a skinned mesh to its baked positions.
#pragma once

#include <Eigen/Core>

#include "host/rig/character.h"

namespace fascicle::rig {

// A joint's transform in its parent's space: translation * rotation * scale.
struct JointParts {
  Vector3d translation, scale;
  Eigen::Vector4d rotation;  // x y z w, unit length
};

// The parts of an affine map. A map that mirrors has a negative scale in x; shear is lost.
JointParts joint_parts(const Eigen::Matrix4d& local);

// Inverse of a matrix whose last row is 0 0 0 1; not finite if it is singular.
Eigen::Matrix4d affine_inverse(const Eigen::Matrix4d& m);

// Solves linear x = y. If `linear` is nearly singular, returns a small x that nearly solves it (damped least
// squares).
Vector3d solve(const Eigen::Matrix3d& linear, const Vector3d& y);

// Rotates v by the shortest rotation from direction a to b, both of unit length.
Vector3d turn(const Vector3d& v, const Vector3d& a, const Vector3d& b);

}  // namespace fascicle::rig
