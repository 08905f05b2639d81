// A pose between the bind pose and another.
#pragma once

#include <vector>

#include "host/scene/scene.h"

namespace fascicle::bake {

// For each joint the map from its own space to the world. At share 0 the bind pose, moved and turned as a
// whole so that joint `root` stands as in `pose`; at share 1 `pose`; between them each joint is turned,
// shifted and stretched relative to its parent, so that limbs keep their lengths. No library trigonometry.
std::vector<Eigen::Matrix4d> blend_from_bind(const scene::Character& character, std::size_t root,
                                             const std::vector<Eigen::Matrix4d>& pose, double share);

}  // namespace fascicle::bake
