// Interpolation between the keys of a clip, glTF 2.0 appendix C. Rotations are quaternions x y z w.
#pragma once

#include <Eigen/Core>

#include "host/rig/character.h"

namespace fascicle::rig {

// translation * rotation * scale; the rotation is normalised first and must not be zero.
Eigen::Matrix4d local_transform(const Vector3d& translation, const Eigen::Vector4d& rotation,
                                const Vector3d& scale);

// Spherical interpolation along the shorter arc from a to b, both of unit length; `u` in [0, 1].
Eigen::Vector4d slerp(const Eigen::Vector4d& a, const Eigen::Vector4d& b, double u);

// Value at `u` in [0, 1] of the cubic from a to b with the given slopes per unit of u.
double hermite(double a, double slope_a, double b, double slope_b, double u);

// The channel's value at `time`, held constant before the first and after the last key: 3 numbers, or a unit
// quaternion.
Eigen::Vector4d sample(const Channel& channel, double time);

}  // namespace fascicle::rig
