// The linear algebra of moving a skinned mesh to where it was baked.
#pragma once

#include <Eigen/Core>

#include "host/rig/character.h"

namespace fascicle::rig {

// A joint's transform in its parent's space, taken apart.
struct JointParts {
  Vector3d translation, scale;
  Eigen::Vector4d rotation;  // x y z w, of length 1
};

// Of a joint under `above`, both from their own space to the world. The signs of the scale are those it has
// at rest.
JointParts joint_parts(const Eigen::Matrix4d& above, const Eigen::Matrix4d& joint,
                       const Vector3d& rest_scale);

// Inverse of a matrix whose last row is 0 0 0 1; not finite where there is none.
Eigen::Matrix4d affine_inverse(const Eigen::Matrix4d& m);

// Solves linear x = y; where `linear` is all but flat, for the smallest x that nearly does.
Vector3d solve(const Eigen::Matrix3d& linear, const Vector3d& y);

// v as the shortest rotation from direction a to b, both of length 1, takes it.
Vector3d turn(const Vector3d& v, const Vector3d& a, const Vector3d& b);

}  // namespace fascicle::rig
