#include "host/drive/motion_breaks.h"

#include <algorithm>
#include <utility>

namespace fascicle::drive {

// A weighted sum of poses; weights sum to 1.
Pose MotionBreaks::mixed(std::initializer_list<std::pair<double, std::uint64_t>> parts) {
  Pose sum;
  for (const auto& [weight, count] : parts) {
    const Pose& pose = timeline_.pose(count);
    if (sum.empty()) sum.assign(pose.size(), Eigen::Matrix4d::Zero());
    for (std::size_t j = 0; j < pose.size(); ++j) sum[j] += weight * pose[j];
  }
  return sum;
}

// The motion after a character's cut in substep `count`, extrapolated back to the beginning of the substep:
// with constant acceleration, unless another cut follows too soon. Only for the joints of that character,
// like the next.
Pose MotionBreaks::followed_back(std::size_t character, std::uint64_t count) {
  if (timeline_.is_cut_of(character, count + 1) || timeline_.is_cut_of(character, count + 2))
    return mixed({{2.0, count}, {-1.0, count + 1}});
  return mixed({{3.0, count}, {-3.0, count + 1}, {1.0, count + 2}});
}

// The pose one substep before the end of substep count - 1, chosen so that the step between them has the
// speed which the ending motion would have in the middle of substep `count`. Both motions are thus taken at
// the same time, and a cut within steady motion changes nothing. If there was a cut in the substep before,
// the motion is the one that began there.
Pose MotionBreaks::followed_on(std::size_t character, std::uint64_t count) {
  const auto is_cut = [&](std::uint64_t k) { return timeline_.is_cut_of(character, k); };
  if (count == 1) return timeline_.pose(0);
  if (is_cut(count - 1)) return followed_back(character, count - 1);
  if (count == 2 || is_cut(count - 2)) return timeline_.pose(count - 2);
  return mixed({{-1.0, count - 1}, {3.0, count - 2}, {-1.0, count - 3}});
}

bool MotionBreaks::accelerates(std::size_t joint, std::uint64_t count) {
  const std::size_t character = character_of_[joint];
  return count >= 2 && !timeline_.is_cut_of(character, count) && !timeline_.is_cut_of(character, count - 1);
}

double MotionBreaks::acceleration_of(std::size_t joint, std::uint64_t count) {
  if (!felt_.has_flesh(joint)) return 0.0;
  const std::uint64_t window = substeps_of_window(h_);
  double largest = 0.0;
  for (std::uint64_t first = count - 1; first >= 1 && count - first <= window; --first) {
    if (first < count - 1 && timeline_.is_cut_of(character_of_[joint], first)) break;
    largest = std::max(largest, felt_.of_joint(joint, {timeline_.pose(first - 1), timeline_.pose(first),
                                                       timeline_.pose(count - 1), timeline_.pose(count), h_,
                                                       static_cast<double>(window) * h_}));
  }
  return largest;
}

bool MotionBreaks::is_bounded(std::uint64_t count) {
  for (std::size_t j = 0; j < character_of_.size(); ++j)
    if (accelerates(j, count) && acceleration_of(j, count) > felt_.limit(j)) return true;
  return false;
}

BreakPoses MotionBreaks::poses(std::uint64_t count) {
  const Pose at = timeline_.pose(count - 1), to = timeline_.pose(count);
  const Pose old = count >= 2 ? timeline_.pose(count - 2) : at;
  Pose ended = old, begun = at, given = at, followed_to, followed_from;
  std::size_t followed = character_of_.size();  // the character that the last two are of
  for (std::size_t j = 0; j < at.size(); ++j) {
    const std::size_t character = character_of_[j];
    if (timeline_.is_cut_of(character, count)) {
      if (followed != character) {
        followed_to = followed_on(character, count);
        followed_from = followed_back(character, count);
        followed = character;
      }
      ended[j] = followed_to[j];
      begun[j] = followed_from[j];
      given[j] = to[j];
      continue;
    }
    if (accelerates(j, count)) {
      const double acceleration = acceleration_of(j, count);
      const double share = acceleration > felt_.limit(j) ? 1.0 - felt_.limit(j) / acceleration : 0.0;
      given[j] = (1.0 - share) * (2.0 * at[j] - old[j]) + share * to[j];
    } else {
      ended[j] = at[j];
    }
  }
  return {std::move(ended), at, std::move(begun), std::move(given)};
}

}  // namespace fascicle::drive
