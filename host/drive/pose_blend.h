// A pose between the bind pose and another.
#pragma once

#include <vector>

#include "host/model/rotation.h"
#include "host/scene/scene.h"

namespace fascicle::drive {

// The linear part of a map, row by row.
model::Matrix3 rows_of(const Eigen::Matrix4d& map);

// For each joint the map from its own space to the world. At share 0: the bind pose, moved and turned as a
// whole so that joint `root` is as in `pose`; at share 1: `pose`. In between, each joint is rotated,
// translated and stretched relative to its parent, so that limbs keep their lengths. Does not use the
// library's trigonometry.
std::vector<Eigen::Matrix4d> blend_from_bind(const rig::Character& character, std::size_t root,
                                             const std::vector<Eigen::Matrix4d>& pose, double share);

}  // namespace fascicle::drive
