// Linear algebra for moving a skinned mesh to its baked positions.
#pragma once

#include <Eigen/Core>

#include "host/rig/character.h"

namespace fascicle::rig {

// A joint's transform in its parent's space, decomposed.
struct JointParts {
  Vector3d translation, scale;
  Eigen::Vector4d rotation;  // x y z w, unit length
};

// For a joint with parent `above`, both as maps from their own space to the world. The scale keeps the signs
// it has at rest.
JointParts joint_parts(const Eigen::Matrix4d& above, const Eigen::Matrix4d& joint,
                       const Vector3d& rest_scale);

// Inverse of a matrix whose last row is 0 0 0 1; not finite if it is singular.
Eigen::Matrix4d affine_inverse(const Eigen::Matrix4d& m);

// Solves linear x = y. If `linear` is nearly singular, returns a small x that nearly solves it (damped least
// squares).
Vector3d solve(const Eigen::Matrix3d& linear, const Vector3d& y);

// Rotates v by the shortest rotation from direction a to b, both of unit length.
Vector3d turn(const Vector3d& v, const Vector3d& a, const Vector3d& b);

}  // namespace fascicle::rig
