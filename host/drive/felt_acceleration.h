// How much of the skeleton's acceleration flesh feels, and where that is bounded.
//
// Keys may leap: a key puts a limb elsewhere within a frame, or a rig flips. Flesh cannot follow, and no
// artist meant the blow. So flesh feels at most the bound of a joint's acceleration, and the rest carries it
// along, as a cut does.
//
// A joint's acceleration is the largest at the corners of the box around the free vertices that follow it
// most, by the second difference of its poses: joints whose flesh is all kinematic throw none.
#pragma once

#include <cstdint>
#include <vector>

#include "host/drive/timeline.h"
#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::drive {

// 1/s^2, times the body's extent: the bound where the scene has none. Clips take the same time whatever the
// size, so accelerations grow with it. docs/design/crushed-flesh.md has those of some clips.
inline constexpr double default_acceleration_limit = 200.0;

// The joint that vertex i follows most; the first of several.
std::uint32_t main_joint(const model::Model& model, std::uint32_t i);

class FeltAcceleration {
 public:
  FeltAcceleration(const scene::Scene& scene, const rig::Character& character, const model::Model& model);

  // Of joint j's flesh, m/s^2.
  double limit(std::size_t j) const { return limit_[j]; }
  // Of joint j, m/s^2; the poses are h seconds apart. 0 where the joint has no free flesh.
  double of_joint(std::size_t j, const Pose& before, const Pose& at, const Pose& after, double h) const;
  // In the middle of the joint's free flesh, beyond the bound too.
  scene::Vector3d in_middle(std::size_t j, const Pose& before, const Pose& at, const Pose& after,
                            double h) const;
  bool has_flesh(std::size_t j) const { return !corners_[j].empty(); }

 private:
  double scale_ = 1.0;
  std::vector<double> limit_;                          // of a joint: by the size of its character
  std::vector<std::vector<scene::Vector3d>> corners_;  // of a joint, its own space; none: no free flesh
};

}  // namespace fascicle::drive
