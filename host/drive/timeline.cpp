#include "host/drive/timeline.h"

#include <algorithm>
#include <cmath>

#include "host/drive/pose_blend.h"
#include "host/rig/pose.h"
#include "host/rig/rig_math.h"

namespace fascicle::drive {

using scene::Vector3d;

Timeline::Timeline(const scene::Scene& scene, const rig::Character& character,
                   std::span<const double> extents, std::uint64_t substeps)
    : scene_(scene),
      character_(character),
      clip_(rig::find_clip(character, scene.clip)),
      substeps_(substeps),
      cycle_(std::max<std::uint64_t>(scene::cycle_frames(scene), 1) * substeps_),
      kept_(substeps_ + 4) {
  for (std::size_t k = 0; k < extents.size(); ++k) {
    Root root;
    const bool is_last = k + 1 >= scene.characters.size();
    const std::size_t end = is_last ? character.skeleton.size() : scene.characters[k + 1].first_joint;
    if (!scene.characters.empty()) root.joint = scene.characters[k].first_joint;
    while (root.joint + 1 < end && !character.skeleton[root.joint].skins) ++root.joint;
    root.cut_distance = scene.motion.cut_distance.value_or(extents[k] > 0.0 ? extents[k] : INFINITY);
    root.is_borne = !scene.characters.empty() && scene.characters[k].bearer;
    roots_.push_back(root);
  }
  const Pose first = rig::joint_transforms_at(character, clip_, scene.start);
  const Pose last = rig::joint_transforms_at(character, clip_, scene.end);
  for (std::size_t j = 0; j < first.size(); ++j) {
    const Vector3d way = (last[j] - first[j]).topRightCorner<3, 1>() * scene.scale;
    const double extent = extents[scene::character_of_joint(scene, j)];
    if (character.skeleton[j].skins && way.norm() > 1e-3 * extent) returns_ = false;
  }
}

double Timeline::clip_time(std::uint64_t count) const {
  const scene::Motion& motion = scene_.motion;
  if (motion.loop == 1 && !motion.seamless) {
    // Rounded only once, so that times of whole frames or tenths of a second come out as written.
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
  if (scene_.characters.empty()) return blend_from_bind(character_, roots_.front().joint, pose(0), share);
  // Blend each character on its own and then place it: in the world's frame its joints would swing about the
  // origin.
  const Pose all = pose(0);
  Pose blended = all;
  for (std::size_t k = 0; k < roots_.size(); ++k) {
    const scene::PlacedCharacter& one = scene_.characters[k];
    const std::size_t first = one.first_joint + std::size_t{1}, count = one.own.skeleton.size();
    Eigen::Matrix4d place = one.place, back = scene::back_from(one);
    if (one.bearer) {
      // The joint that bears it comes earlier and is already blended.
      place = (blended[*one.bearer] * place).eval();
      back = (back * rig::affine_inverse(all[*one.bearer])).eval();
      blended[one.first_joint] = place * one.own.root;
    }
    Pose own;
    for (std::size_t j = 0; j < count; ++j) own.push_back(back * all[first + j]);
    own = blend_from_bind(one.own, roots_[k].joint - first, own, share);
    for (std::size_t j = 0; j < count; ++j) blended[first + j] = place * own[j];
  }
  return blended;
}

Vector3d Timeline::place_of(const Root& root, const Pose& pose) const {
  return pose[root.joint].topRightCorner<3, 1>() * scene_.scale;
}

Vector3d Timeline::root(const Pose& pose) const {
  // No other character bears the first.
  Vector3d sum = place_of(roots_.front(), pose);
  std::size_t count = 1;
  for (std::size_t k = 1; k < roots_.size(); ++k) {
    if (roots_[k].is_borne) continue;
    sum += place_of(roots_[k], pose);
    ++count;
  }
  return sum / static_cast<double>(count);
}

double Timeline::root_step(const Root& root, std::uint64_t from, std::uint64_t to) {
  const Vector3d start = place_of(root, pose(from));
  return (place_of(root, pose(to)) - start).norm();
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

// Whether the root moves at the speed of a jump, over both the substep and its frame: a quick start is not a
// jump.
bool Timeline::is_jump(const Root& root, std::uint64_t count) {
  if (root.is_borne || count == 0 || begins_cycle(count)) return false;
  if (!(root_step(root, count - 1, count) > root.cut_distance / static_cast<double>(substeps_))) return false;
  const std::uint64_t frame = (count - 1) / substeps_;
  return root_step(root, frame * substeps_, (frame + 1) * substeps_) > root.cut_distance;
}

bool Timeline::jumps_about(const Root& root, std::uint64_t count) {
  if (is_jump(root, count)) return true;
  // A jump between two keys of a linear channel lasts as long as the interval between them, and may partly
  // fall into the substeps at its ends.
  const double noticeable = 0.125 * root.cut_distance / static_cast<double>(substeps_);
  return root_step(root, count - 1, count) > noticeable &&
         (is_jump(root, count - 1) || is_jump(root, count + 1));
}

bool Timeline::is_cut(std::uint64_t count) {
  if (begins_cycle(count)) return !returns_;
  return is_marked(count) || std::any_of(roots_.begin(), roots_.end(),
                                         [&](const Root& root) { return jumps_about(root, count); });
}

}  // namespace fascicle::drive
