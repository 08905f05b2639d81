// The skeleton's motion on a bake's time line: the pose at the end of each substep, and where there are cuts.
//
// Substeps are counted from 0, the first pose, which is frame 0. With one cycle, substep c ends at the clip
// time start + c / (substeps fps). With several, or seamless, each cycle takes a whole number of frames and
// the clip is stretched to fill them, by less than half a frame per cycle: frames then repeat exactly. After
// the last cycle the last pose is held.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "host/scene/scene.h"

namespace fascicle::drive {

using Pose = std::vector<Eigen::Matrix4d>;  // per joint: from its own space to the world, the file's metres

// The acceleration that flesh feels is measured over at most this many substeps.
inline constexpr std::uint64_t most_substeps_of_window = 64;

class Timeline {
 public:
  // `extents`: of each of the scene's characters, or of the only one, metres. The scene and its character
  // must outlive it.
  Timeline(const scene::Scene& scene, const rig::Character& character, std::span<const double> extents,
           std::uint64_t substeps);

  // Keeps some hundred poses, the last that were requested.
  const Pose& pose(std::uint64_t count);
  // The pose that is `share` (0 to 1) of the way to the first pose from the bind pose, which is placed and
  // turned like the first pose's root. With several characters, each relative to its own root.
  Pose preroll_pose(double share);

  // The clip's time at the end of substep `count`, s.
  double clip_time(std::uint64_t count) const;
  // Whether that is after the clip's end, as in a last frame that the clip does not fill.
  bool is_over(std::uint64_t count) const;

  // Position of the root joint, metres of the scene; for several characters the mean over those that no other
  // bears, and that have flesh or bear some.
  scene::Vector3d root(const Pose& pose) const;

  // Whether there is a cut between the ends of substeps count - 1 and count, count >= 1: at a marked cut; if
  // a root jumps whose flesh it carries; or where a new cycle begins, if the clip does not end as it begins.
  bool is_cut(std::uint64_t count);
  // The same for one character, a prop too: others' jumps do not count, except that of one that bears it.
  bool is_cut_of(std::size_t character, std::uint64_t count);
  // At a marked cut, or between cycles.
  bool is_cut_of_all(std::uint64_t count) const;
  // The jumps of characters with flesh, or of their bearers, in the first cycle; not those at marked cuts.
  struct Jump {
    std::size_t character = 0;
    std::uint64_t frame = 0;  // whose end it leads to
    double distance = 0.0;    // m
  };
  std::vector<Jump> jumps();
  // Whether the clip's last pose equals its first, within a thousandth of its body's extent at every joint.
  bool returns() const { return returns_; }

 private:
  bool is_marked(std::uint64_t count) const;
  bool begins_cycle(std::uint64_t count) const;
  // A character's root joint.
  struct Root {
    std::size_t joint = 0;
    double cut_distance = 0.0;   // m: more than this in a frame may be a jump
    std::size_t leader = 0;      // the character that jumps with it: it, or the last in its line of bearers
    bool carries_flesh = false;  // its own, or that of a character that jumps with it
  };
  scene::Vector3d place_of(const Root& root, const Pose& pose) const;
  double root_step(const Root& root, std::uint64_t from, std::uint64_t to);
  double frame_step(const Root& root, std::uint64_t frame);
  bool stands_out(const Root& root, std::uint64_t frame);
  bool is_jump_in_frame(const Root& root, std::uint64_t frame);
  bool is_jump(const Root& root, std::uint64_t count);
  bool jumps_about(const Root& root, std::uint64_t count);

  const scene::Scene& scene_;
  const rig::Character& character_;
  const rig::Clip* clip_;
  std::vector<Root> roots_;                 // one per character
  std::uint64_t substeps_ = 1, cycle_ = 1;  // per frame, per cycle
  bool returns_ = true;
  struct Kept {
    std::uint64_t count = ~std::uint64_t{0};
    Pose pose;
    std::vector<std::optional<bool>> is_cut;  // per character; empty: not asked yet
  };
  std::vector<Kept> kept_;  // the last poses requested, by count modulo the size
  std::map<std::uint64_t, std::vector<scene::Vector3d>> places_;  // of all roots at ends of frames
};

}  // namespace fascicle::drive
