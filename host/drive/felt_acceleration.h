// How much of the skeleton's acceleration flesh feels, and the limit on it.
//
// Keys may jump: a key moves a limb elsewhere within one frame, or a rig flips. Flesh cannot follow, and no
// artist intended the impact. So flesh feels a joint's acceleration only up to the limit; the rest carries it
// along, as a cut does.
//
// A joint's acceleration is the largest at the corners of the bounding box of the free vertices that follow
// it most: joints with only kinematic flesh have none. It is the change of velocity over `felt_window`, or
// over a substep if that is longer. So of a sudden change of velocity flesh feels the same, however short the
// substep.
#pragma once

#include <cstdint>
#include <vector>

#include "host/drive/timeline.h"
#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::drive {

// 1/s^2, times the body's extent: the limit if the scene has none. Clips take the same time whatever the
// size, so accelerations grow with size. docs/design/crushed-flesh.md lists those of some clips.
inline constexpr double default_acceleration_limit = 200.0;

// s
inline constexpr double felt_window = 1.0 / 240.0;
// The number of whole substeps of h seconds that are nearest to `felt_window`, at least 1.
std::uint64_t substeps_of_window(double h);

// The joint with the largest weight in vertex i; the first if several are equal.
std::uint32_t main_joint(const model::Model& model, std::uint32_t i);

class FeltAcceleration {
 public:
  FeltAcceleration(const scene::Scene& scene, const rig::Character& character, const model::Model& model);

  // For joint j's flesh, m/s^2.
  double limit(std::size_t j) const { return limit_[j]; }
  // The ends of two substeps of h seconds, an earlier and a later one.
  struct Substeps {
    const Pose &first_from, &first_to, &last_from, &last_to;
    double h, apart;  // s
  };
  // For joint j, m/s^2. 0 if the joint has no free flesh.
  double of_joint(std::size_t j, const Substeps& substeps) const;
  // At the middle of the joint's free flesh, not limited.
  scene::Vector3d in_middle(std::size_t j, const Pose& before, const Pose& at, const Pose& after,
                            double h) const;
  bool has_flesh(std::size_t j) const { return !corners_[j].empty(); }

 private:
  double scale_ = 1.0;
  std::vector<double> limit_;                          // per joint: from the size of its character
  std::vector<std::vector<scene::Vector3d>> corners_;  // per joint, in its own space; empty: no free flesh
};

}  // namespace fascicle::drive
