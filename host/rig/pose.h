// Poses of a clip at any time.
#pragma once

#include <vector>

#include "host/rig/character.h"
#include "host/rig/rig_math.h"

namespace fascicle::rig {

// The clip with this exact name, by index if `name` is a number, or the first clip if it is empty. Otherwise
// the only clip that matches ignoring case, or whose name ends with `name` after a separator: `Gallop` finds
// `AnimalArmature|Gallop`. Null if the character has no clip and `name` is empty. Throws SceneError that
// lists the clips.
const Clip* find_clip(const Character& character, const std::string& name);

// For each joint the affine map from the bind pose (metres) to the pose at `time` (s, clamped to the clip;
// null clip: the rest transforms). The same bits on every machine, because it uses no library trigonometry.
std::vector<Eigen::Matrix4d> pose_at(const Character& character, const Clip* clip, double time);

// For each joint the affine map from its own space to the pose at `time` (metres), as above; pose_at
// multiplies these by the inverse bind matrices.
std::vector<Eigen::Matrix4d> joint_transforms_at(const Character& character, const Clip* clip, double time);

// Each joint's transform in its parent's space at `time`, as the channels give it: a scale of zero or below
// zero keeps its rotation, which no map to the world would tell.
std::vector<JointParts> joint_parts_at(const Character& character, const Clip* clip, double time);

}  // namespace fascicle::rig
