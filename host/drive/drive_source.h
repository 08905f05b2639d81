// From a scene's clip, gravity and forces to the drive of each frame.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "host/drive/timeline.h"
#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/scene/scene.h"
#include "host/scene/solids.h"

namespace fascicle::drive {

// The scene and model must outlive it. Frame k covers the time from start + (k-1)/fps to start + k/fps;
// substep s of it ends at start + (k - 1 + s/substeps)/fps, s = 1..substeps, and the clip is sampled there
// (for several cycles, see timeline.h). Each frame's origin is the root joint's position at the frame's end
// rounded to whole working units (constant without a skeleton).
//
// The spans of a drive stay valid until the next call that returns one.
class DriveSource {
 public:
  // Without `substeps`, the scene's number; throws std::invalid_argument if the scene does not state one.
  DriveSource(const scene::Scene& scene, const model::Model& model);
  DriveSource(const scene::Scene& scene, const model::Model& model, std::uint32_t substeps);
  ~DriveSource();

  // The state before frame 1 if the flesh has followed the skeleton: skinned to the first pose, with the
  // velocity at which the clip begins.
  model::State initial_state() const;
  // The state at the end of frame k, if the flesh has followed the skeleton up to there. In frame 0 and the
  // last one only its positions have a meaning.
  model::State state_on_skeleton(std::uint64_t frame) const;
  std::uint32_t substeps() const;  // per frame
  // The drive of frame k >= 1. Frames may be requested in any order.
  model::Drive drive(std::uint64_t frame);

  // Joints that accelerate flesh beyond the limit on what it feels (felt_acceleration.h) in one cycle of the
  // clip: each once, with its largest acceleration, the worst first. Runs through all substeps; asks
  // `goes_on` in each frame, and stops when it is false.
  using GoesOn = std::function<bool()>;
  struct Thrown {
    std::size_t joint = 0;
    double acceleration = 0.0;  // m/s^2
    double time = 0.0;          // s of the clip
    std::uint64_t frame = 0;    // in which that occurs
  };
  std::vector<Thrown> thrown(const GoesOn& goes_on = {});
  // Where a root jumps in the first cycle, and no cut is marked (timeline.h).
  std::vector<Timeline::Jump> jumps();
  double acceleration_limit(std::size_t joint) const;  // m/s^2; 0 without a skeleton

  // The accelerations at the middle of each joint's flesh, in one cycle of the clip, m/s^2: gravity as it
  // acts on the rest shape, and the negated acceleration of the skeleton there, within the limit on what
  // flesh feels. Calls visit(throws) at the end of each substep; both are 0 for joints without free flesh.
  // `goes_on`: as for thrown().
  struct Throw {
    scene::Vector3d gravity = scene::Vector3d::Zero(), inertia = scene::Vector3d::Zero();
  };
  void for_each_throw(const std::function<void(const std::vector<Throw>& of_joint)>& visit,
                      const GoesOn& goes_on = {});

  // Each joint's map from its own space to the world (metres of the file) at the end of a frame; frame 0 is
  // the first pose. Empty without a skeleton.
  std::vector<Eigen::Matrix4d> joints(std::uint64_t frame);
  // The scene's solids at the end of a frame, metres of the scene.
  std::vector<scene::Solid> solids(std::uint64_t frame);
  // The clip time shown in a frame, s; 0 without a skeleton.
  double clip_time(std::uint64_t frame) const;

  // Before frame 0. The preroll begins at rest in preroll_state() and lasts preroll_frames() frames, numbered
  // from 1; its motion begins and ends at zero speed. Without a preroll, its state is that of the first pose.
  std::uint64_t preroll_frames() const;
  model::State preroll_state() const;
  model::Drive preroll_drive(std::uint64_t frame);
  // The drive of a frame that holds the first pose.
  model::Drive settle_drive();
  // The state before frame 1, from one at rest in the first pose: given the velocity at which the clip
  // begins.
  model::State started(const model::State& resting) const;
  // The state before frame 1, from the one at the end of the clip's cycle: carried to the first pose if the
  // clip does not end there. Its frame is 0 again.
  model::State begun_again(const model::State& cycled) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace fascicle::drive
