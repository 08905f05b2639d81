// Drives for a body whose skeleton the caller moves: takes poses frame by frame.
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

// The scene and model must outlive it. Unlike with a clip (felt_acceleration.h), the acceleration that flesh
// feels is not limited: the caller is responsible for the motion of its poses.
class PoseDrive {
 public:
  PoseDrive(const scene::Scene& scene, const model::Model& model, std::uint32_t substeps);

  // The state at rest in a pose (empty without a skeleton), from which the next drive continues.
  model::State start(const Pose& pose);
  // Continues from this pose without making a state: for use after loading a solver's state, with the pose at
  // that time.
  void stand(const Pose& pose) { last_ = pose; }
  const Pose& last() const { return last_; }

  // The drive of one frame of 1/fps that ends at the last of `poses`: one pose per substep, or a single one,
  // up to which the joints' maps are interpolated linearly. Without a skeleton there are none. `time` is the
  // scene time at the frame's end, s; forces and contractions are evaluated there. `jumps`: the body is
  // carried along to the first pose, and its flesh does not feel it. The spans stay valid until the next
  // call.
  model::Drive drive(std::span<const Pose> poses, double time, bool jumps);

 private:
  scene::Vector3d origin_of(const Pose& pose) const;

  const scene::Scene& scene_;
  const model::Model& model_;
  std::size_t substeps_;                // per frame
  std::optional<Timeline> timeline_;    // empty without a skeleton
  std::optional<MuscleDrive> muscles_;  // empty without muscles
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
