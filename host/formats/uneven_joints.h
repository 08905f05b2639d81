// Joints that are scaled unevenly: by an animation, or by a node above them.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "host/gltf/gltf_rig.h"

namespace fascicle::formats {

// Per vertex of a part: whether one of its joints lengthens some directions more than others, by more than
// `tolerance` as a share. `slots`: for each of the part's slots, the transform from its bind pose. False for
// parts without joints.
std::vector<char> below_uneven_joints(const gltf::RigPart& part, const std::vector<Eigen::Matrix4d>& slots,
                                      double tolerance);

}  // namespace fascicle::formats
