// Poses of a clip at any time.
#pragma once

#include <vector>

#include "host/rig/character.h"

namespace fascicle::rig {

// The clip named `name`, by index if it is a number, or the first if empty; else the one clip that is called
// so in other letters' case, or whose name ends so behind a separator: `Gallop` is `AnimalArmature|Gallop`.
// Null if the character has no clip and name is empty. Throws SceneError with the names there are.
const Clip* find_clip(const Character& character, const std::string& name);

// For each joint the affine map from the bind pose (metres) to the pose at `time` (s, clamped to the clip;
// null clip: the rest transforms). The same bits on every machine: no library trigonometry.
std::vector<Eigen::Matrix4d> pose_at(const Character& character, const Clip* clip, double time);

// For each joint the affine map from its own space to the pose at `time` (metres), as above; pose_at is this
// after the inverse bind matrices.
std::vector<Eigen::Matrix4d> joint_transforms_at(const Character& character, const Clip* clip, double time);

}  // namespace fascicle::rig
