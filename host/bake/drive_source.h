// From a scene's clip, gravity and forces to the drive of each frame.
#pragma once

#include <memory>

#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/scene/scene.h"

namespace fascicle::bake {

// The scene and model must outlive it. Frame k covers the time from start + (k-1)/fps to start + k/fps;
// substep s of it ends at start + (k - 1 + s/substeps)/fps, s = 1..substeps, and the clip is sampled there.
// Each frame's origin is the root joint's position at the frame's end rounded to whole working units
// (constant without a skeleton).
class DriveSource {
 public:
  DriveSource(const scene::Scene& scene, const model::Model& model);
  ~DriveSource();

  // State before frame 1.
  model::State initial_state() const;
  // The drive of frame k >= 1. Its spans stay valid until the next call. Frames may be asked for in any
  // order.
  model::Drive drive(std::uint64_t frame);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace fascicle::bake
