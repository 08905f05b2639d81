// Muscle values for a pose: equation (17)'s tau and activation, contraction and twist.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/drive/timeline.h"
#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/scene/muscle_bones.h"

namespace fascicle::drive {

// Number of regions whose stretch (17) would leave [0.25, 4] in one substep.
std::uint64_t clamped_regions(const model::Model& model, std::span<const shader::Muscle> muscles);

class MuscleDrive {
 public:
  // The scene and its character must outlive it. Throws scene::SceneError if muscles do not fit the bones.
  MuscleDrive(const scene::Scene& scene, const rig::Character& character);

  // Appends one record per muscle, for the pose at clip time `time`.
  void append(const Pose& pose, double time, std::vector<shader::Muscle>& to) const;

 private:
  // A muscle's constant data. Directions are unit vectors in the carrier's rest frame.
  struct Prepared {
    scene::MuscleBones bones;
    double resting = 0.0;  // activation in the bind pose
    scene::Vector3d hinge =
        scene::Vector3d::Zero();            // tau where the clip bends the joint most; 0: it never does
    const rig::Channel* channel = nullptr;  // for the contraction
    std::uint32_t axis = 0;
    double at_rest = 0.0;  // the channel's value without a clip
  };
  // The bend of a joint: cosine and sine of its angle, which is 0 when straight, and tau times the sine, in
  // the world.
  struct Bend {
    double cosine = 1.0, sine = 0.0;
    scene::Vector3d tau = scene::Vector3d::Zero();
  };
  Bend bend_of(const scene::Muscle& muscle, const scene::MuscleBones& bones, const scene::Vector3d& upper,
               const scene::Vector3d& joint, const scene::Vector3d& end) const;
  Bend bend_in(std::size_t muscle, const Pose& pose) const;
  scene::Vector3d at_rest(std::size_t muscle, const Pose& pose, const scene::Vector3d& direction) const;
  double twist_in(std::size_t muscle, const Pose& pose) const;
  // One pass over the clip's frames for all muscles.
  void find_hinges(const rig::Clip* clip);

  const scene::Scene& scene_;
  const rig::Character& character_;
  std::vector<Prepared> prepared_;
};

}  // namespace fascicle::drive
