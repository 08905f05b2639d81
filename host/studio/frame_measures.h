// The measurements of a frame for the studio's curves.
#pragma once

#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/studio/wire.h"

namespace fascicle::studio {

// Stores the rest volume. The model must outlive it.
class FrameMeasures {
 public:
  explicit FrameMeasures(const model::Model& model);
  // Fills lag, energy, volume, inverted and speed from the frame's positions and, if present, its velocities
  // and skinned positions. Lag is 0 without a skeleton, and NaN if a body with a skeleton has no skinned
  // positions in the frame.
  void fill(const model::Frame& frame, FrameNumbers& numbers) const;

 private:
  const model::Model* model_;
  double rest_volume_ = 0.0;
};

}  // namespace fascicle::studio
