// Drives of a body whose skeleton somebody else moves: poses in, frame by frame.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "host/drive/collider_drive.h"
#include "host/drive/muscle_drive.h"
#include "host/drive/timeline.h"
#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/scene/scene.h"

namespace fascicle::drive {

// The scene and model must outlive it. What the flesh feels of the skeleton is not bounded here, as it is of
// a clip (felt_acceleration.h): whoever gives poses answers for how they move.
class PoseDrive {
 public:
  PoseDrive(const scene::Scene& scene, const model::Model& model, std::uint32_t substeps);

  // The state at rest in a pose (empty without a skeleton), from which the next drive goes on.
  model::State start(const Pose& pose);
  // Goes on from here without a state of its own: after a solver's state was loaded, with the pose it stood
  // in.
  void stand(const Pose& pose) { last_ = pose; }
  const Pose& last() const { return last_; }

  // The drive of one frame of 1/fps to the last of `poses`: one for each substep, or one in all, before which
  // the joints' maps are mixed linearly. Without a skeleton there are none. `time` is the scene's at the
  // frame's end, s: forces and contractions are read there. `jumps`: the body is carried along to the first
  // of the poses, and its flesh feels nothing of that. The spans stay valid until the next call.
  model::Drive drive(std::span<const Pose> poses, double time, bool jumps);

 private:
  scene::Vector3d origin_of(const Pose& pose) const;

  const scene::Scene& scene_;
  const model::Model& model_;
  std::size_t substeps_;                // of a frame
  std::optional<Timeline> timeline_;    // nothing without a skeleton
  std::optional<MuscleDrive> muscles_;  // nothing without muscles
  Pose last_;
  std::vector<shader::Bone> bones_, before_, after_;
  std::vector<shader::Muscle> muscle_values_;
  std::vector<shader::Force> forces_;
  ColliderDrive collider_drive_;
  std::vector<shader::Collider> colliders_;
  std::vector<float> decay_;
  std::vector<model::Cut> cuts_;
};

}  // namespace fascicle::drive
