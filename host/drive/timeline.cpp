#include "host/drive/timeline.h"

#include <algorithm>
#include <cmath>

#include "host/drive/pose_blend.h"
#include "host/rig/pose.h"
#include "host/rig/rig_math.h"

namespace fascicle::drive {

using scene::Vector3d;

namespace {

constexpr double rounding = 1e-9;  // s

}  // namespace

Timeline::Timeline(const scene::Scene& scene, const rig::Character& character,
                   std::span<const double> extents, std::uint64_t substeps)
    : scene_(scene),
      character_(character),
      clip_(rig::find_clip(character, scene.clip)),
      substeps_(substeps),
      cycle_(std::max<std::uint64_t>(scene::cycle_frames(scene), 1) * substeps_),
      kept_(substeps_ + 4 + most_substeps_of_window) {
  for (std::size_t k = 0; k < extents.size(); ++k) {
    Root root;
    const bool is_last = k + 1 >= scene.characters.size();
    const std::size_t end = is_last ? character.skeleton.size() : scene.characters[k + 1].first_joint;
    if (!scene.characters.empty()) root.joint = scene.characters[k].first_joint;
    while (root.joint + 1 < end && !character.skeleton[root.joint].skins) ++root.joint;
    root.cut_distance = scene.motion.cut_distance.value_or(extents[k] > 0.0 ? extents[k] : INFINITY);
    root.leader = k;
    if (!scene.characters.empty()) {
      // A bearer comes before those that it bears.
      if (const auto bearer = scene.characters[k].bearer)
        root.leader = roots_[scene::character_of_joint(scene, *bearer)].leader;
    }
    roots_.push_back(root);
  }
  for (const std::size_t k : scene::characters_with_flesh(scene))
    roots_.at(roots_.at(k).leader).carries_flesh = true;
  const Pose first = rig::joint_transforms_at(character, clip_, scene.start);
  const Pose last = rig::joint_transforms_at(character, clip_, scene.end);
  for (std::size_t j = 0; j < first.size(); ++j) {
    const Vector3d way = (last[j] - first[j]).topRightCorner<3, 1>() * scene.scale;
    const double extent = extents[scene::character_of_joint(scene, j)];
    // A joint may turn in its place. Its flesh lies about a tenth of the body's extent away from it.
    const Eigen::Matrix3d turn =
        ((last[j] - first[j]) * character.skeleton[j].inverse_bind).topLeftCorner<3, 3>();
    const bool moves = way.norm() > 1e-3 * extent || 0.1 * turn.norm() > 1e-3;
    if (character.skeleton[j].skins && moves) returns_ = false;
  }
}

double Timeline::clip_time(std::uint64_t count) const {
  const scene::Motion& motion = scene_.motion;
  if (motion.loop == 1 && !motion.seamless) {
    // Rounded only once, so that times of whole frames or tenths of a second come out as written.
    const auto time_of = [&](std::uint64_t substeps) {
      return scene_.start + static_cast<double>(substeps) / (static_cast<double>(substeps_) * scene_.fps);
    };
    if (!(motion.hold > 0.0)) return time_of(count);
    // If the end is not at a whole frame, the nearest frame's pose is held, or the end's if that comes
    // before.
    const double last = time_of(cycle_);
    const double held = last > scene_.end - rounding ? scene_.end : last;
    return count > cycle_ ? held : std::min(time_of(count), held);
  }
  if (count == 0) return scene_.start;
  if (count > motion.loop * cycle_) return scene_.end;
  const std::uint64_t in_cycle = (count - 1) % cycle_ + 1;
  return scene_.start +
         (scene_.end - scene_.start) * (static_cast<double>(in_cycle) / static_cast<double>(cycle_));
}

bool Timeline::is_over(std::uint64_t count) const {
  return clip_time(count) > scene_.end + rounding;
}

const Pose& Timeline::pose(std::uint64_t count) {
  Kept& kept = kept_[count % kept_.size()];
  if (kept.count != count || kept.pose.empty()) {
    kept.pose = rig::joint_transforms_at(character_, clip_, clip_time(count));
    kept.count = count;
    kept.is_cut.clear();
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
  Vector3d sum = Vector3d::Zero();
  std::size_t count = 0;
  for (const Root& root : roots_) {
    if (!root.carries_flesh) continue;
    sum += place_of(root, pose);
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

// How far the root moves in frame `frame` + 1, m.
double Timeline::frame_step(const Root& root, std::uint64_t frame) {
  constexpr std::size_t most_places = 4096;
  if (places_.size() > most_places) places_.clear();
  const auto places = [&](std::uint64_t k) -> const std::vector<Vector3d>& {
    std::vector<Vector3d>& there = places_[k];
    if (there.empty()) {
      const Pose all = rig::joint_transforms_at(character_, clip_, clip_time(k * substeps_));
      for (const Root& one : roots_) there.push_back(place_of(one, all));
    }
    return there;
  };
  const auto k = static_cast<std::size_t>(&root - roots_.data());
  return (places(frame + 1)[k] - places(frame)[k]).norm();
}

// Whether a frame's step is far from the usual in the frames before and after it: small bodies may move
// further than their size in every frame.
bool Timeline::stands_out(const Root& root, std::uint64_t frame) {
  constexpr double seconds_around = 0.25, times_the_usual = 4.0;
  const double step = frame_step(root, frame);
  const auto reach = static_cast<std::uint64_t>(std::ceil(seconds_around * scene_.fps));
  const auto is_unusual = [&](std::uint64_t first, std::uint64_t end) {
    std::vector<double> steps;
    for (std::uint64_t k = first; k < end; ++k) steps.push_back(frame_step(root, k));
    if (steps.empty()) return true;
    const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
    std::nth_element(steps.begin(), middle, steps.end());
    return step > times_the_usual * *middle;
  };
  const std::uint64_t frames = scene::frame_count(scene_);
  return is_unusual(frame - std::min(frame, reach), frame) &&
         is_unusual(frame + 1, std::min(frame + 1 + reach, frames));
}

bool Timeline::is_jump_in_frame(const Root& root, std::uint64_t frame) {
  return frame_step(root, frame) > root.cut_distance &&
         (scene_.motion.cut_distance || stands_out(root, frame));
}

std::vector<Timeline::Jump> Timeline::jumps() {
  std::vector<Jump> found;
  for (std::uint64_t frame = 0; frame < cycle_ / substeps_; ++frame)
    for (std::size_t k = 0; k < roots_.size(); ++k) {
      if (!roots_[k].carries_flesh) continue;
      if (!is_jump_in_frame(roots_[k], frame)) continue;
      bool marked = false;
      for (std::uint64_t s = 1; s <= substeps_; ++s) marked = marked || is_marked(frame * substeps_ + s);
      if (!marked) found.push_back({k, frame + 1, frame_step(roots_[k], frame)});
    }
  return found;
}

// Whether the root moves at the speed of a jump, over both the substep and its frame: a quick start is not a
// jump, and neither is a quick flight, unless the scene says from which distance on it is one.
bool Timeline::is_jump(const Root& root, std::uint64_t count) {
  if (count == 0 || begins_cycle(count)) return false;
  if (!(root_step(root, count - 1, count) > root.cut_distance / static_cast<double>(substeps_))) return false;
  return is_jump_in_frame(root, (count - 1) / substeps_);
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
  for (std::size_t k = 0; k < roots_.size(); ++k)
    if (roots_[k].carries_flesh && is_cut_of(k, count)) return true;
  return false;
}

bool Timeline::is_cut_of_all(std::uint64_t count) const {
  return begins_cycle(count) ? !returns_ : is_marked(count);
}

bool Timeline::is_cut_of(std::size_t character, std::uint64_t count) {
  if (begins_cycle(count)) return !returns_;
  (void)pose(count);
  std::vector<std::optional<bool>>& known = kept_[count % kept_.size()].is_cut;
  if (known.empty()) known.resize(roots_.size());
  const std::size_t leader = roots_[character].leader;
  if (!known[leader]) known[leader] = is_marked(count) || jumps_about(roots_[leader], count);
  return *known[leader];
}

}  // namespace fascicle::drive
