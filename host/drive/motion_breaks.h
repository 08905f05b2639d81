// Breaks in the skeleton's motion, over which flesh is carried instead of dragged: cuts, and joints that
// accelerate more than their flesh feels (felt_acceleration.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <utility>
#include <vector>

#include "host/drive/felt_acceleration.h"
#include "host/drive/timeline.h"

namespace fascicle::drive {

// A substep's motion up to a break, from `ended` to `at`, and the motion after it, from `begun` to `given`.
struct BreakPoses {
  Pose ended, at, begun, given;
};

class MotionBreaks {
 public:
  // All but `h` must outlive it. `character_of`: per joint. `h`: a substep, s.
  MotionBreaks(Timeline& timeline, const FeltAcceleration& felt, const std::vector<std::size_t>& character_of,
               double h)
      : timeline_(timeline), felt_(felt), character_of_(character_of), h_(h) {}

  // Whether the ends of substeps count - 2, count - 1 and count belong to one motion of the joint's
  // character.
  bool accelerates(std::size_t joint, std::uint64_t count);
  // m/s^2: what a joint that accelerates() has into substep `count`, since the last cut at the most. The
  // largest change of velocity within the window counts, so that a pose that flips and holds is bounded where
  // it begins and where it ends.
  double acceleration_of(std::size_t joint, std::uint64_t count);
  // Whether a joint's acceleration into substep `count` exceeds the limit on what its flesh feels.
  bool is_bounded(std::uint64_t count);

  // Of a break between the ends of substeps count - 1 and count. A character with a cut there is carried over
  // it. All others stay in place, and their flesh receives that part of the skeleton's change of velocity
  // into substep `count` which it is not supposed to feel.
  BreakPoses poses(std::uint64_t count);

 private:
  Pose mixed(std::initializer_list<std::pair<double, std::uint64_t>> parts);
  Pose followed_back(std::size_t character, std::uint64_t count);
  Pose followed_on(std::size_t character, std::uint64_t count);

  Timeline& timeline_;
  const FeltAcceleration& felt_;
  const std::vector<std::size_t>& character_of_;
  double h_;  // s
};

}  // namespace fascicle::drive
