#include "host/drive/timeline.h"

#include <algorithm>
#include <cmath>

#include "host/drive/pose_blend.h"
#include "host/rig/pose.h"

namespace fascicle::drive {

using scene::Vector3d;

Timeline::Timeline(const scene::Scene& scene, const rig::Character& character, double extent,
                   std::uint64_t substeps)
    : scene_(scene),
      character_(character),
      clip_(rig::find_clip(character, scene.clip)),
      substeps_(substeps),
      cycle_(std::max<std::uint64_t>(scene::cycle_frames(scene), 1) * substeps_),
      cut_distance_(scene.motion.cut_distance.value_or(extent > 0.0 ? extent : INFINITY)),
      kept_(substeps_ + 4) {
  while (root_ + 1 < character.skeleton.size() && !character.skeleton[root_].skins) ++root_;
  const Pose first = rig::joint_transforms_at(character, clip_, scene.start);
  const Pose last = rig::joint_transforms_at(character, clip_, scene.end);
  for (std::size_t j = 0; j < first.size(); ++j) {
    const Vector3d way = (last[j] - first[j]).topRightCorner<3, 1>() * scene.scale;
    if (character.skeleton[j].skins && way.norm() > 1e-3 * extent) returns_ = false;
  }
}

double Timeline::clip_time(std::uint64_t count) const {
  const scene::Motion& motion = scene_.motion;
  if (motion.loop == 1 && !motion.seamless) {
    // One rounding, so that times that are whole frames or tenths of a second come out as written.
    const double t =
        scene_.start + static_cast<double>(count) / (static_cast<double>(substeps_) * scene_.fps);
    return motion.hold > 0.0 && count > cycle_ ? scene_.end : t;
  }
  if (count == 0) return scene_.start;
  if (count > motion.loop * cycle_) return scene_.end;
  const std::uint64_t in_cycle = (count - 1) % cycle_ + 1;
  return scene_.start +
         (scene_.end - scene_.start) * (static_cast<double>(in_cycle) / static_cast<double>(cycle_));
}

const Pose& Timeline::pose(std::uint64_t count) {
  Kept& kept = kept_[count % kept_.size()];
  if (kept.count != count || kept.pose.empty()) {
    kept.pose = rig::joint_transforms_at(character_, clip_, clip_time(count));
    kept.count = count;
  }
  return kept.pose;
}

Pose Timeline::preroll_pose(double share) {
  return blend_from_bind(character_, root_, pose(0), share);
}

Vector3d Timeline::root(const Pose& pose) const {
  return pose[root_].topRightCorner<3, 1>() * scene_.scale;
}

double Timeline::root_step(std::uint64_t from, std::uint64_t to) {
  const Vector3d start = root(pose(from));
  return (root(pose(to)) - start).norm();
}

bool Timeline::begins_cycle(std::uint64_t count) const {
  return count > 1 && (count - 1) % cycle_ == 0 && count <= scene_.motion.loop * cycle_;
}

bool Timeline::is_marked(std::uint64_t count) const {
  if (begins_cycle(count)) return false;
  const double from = clip_time(count - 1), to = clip_time(count);
  const auto& cuts = scene_.motion.cuts;
  return std::any_of(cuts.begin(), cuts.end(), [&](double t) { return from < t && t <= to; });
}

// The root's speed is that of a jump, both over the substep and over its frame: a quick start is none.
bool Timeline::is_jump(std::uint64_t count) {
  if (count == 0 || begins_cycle(count)) return false;
  if (!(root_step(count - 1, count) > cut_distance_ / static_cast<double>(substeps_))) return false;
  const std::uint64_t frame = (count - 1) / substeps_;
  return root_step(frame * substeps_, (frame + 1) * substeps_) > cut_distance_;
}

bool Timeline::is_cut(std::uint64_t count) {
  if (begins_cycle(count)) return !returns_;
  if (is_marked(count) || is_jump(count)) return true;
  // A jump between two keys of a linear channel takes as long as they lie apart, and a part of it may fall
  // into the substeps at its ends.
  const double noticeable = 0.125 * cut_distance_ / static_cast<double>(substeps_);
  return root_step(count - 1, count) > noticeable && (is_jump(count - 1) || is_jump(count + 1));
}

}  // namespace fascicle::drive
