// What the studio's curves show of a frame.
#pragma once

#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/studio/wire.h"

namespace fascicle::studio {

// Knows the rest shape's volume. The model must outlive it.
class FrameMeasures {
 public:
  explicit FrameMeasures(const model::Model& model);
  // Fills lag, energy, volume, inverted and speed from the frame's positions, and its velocities and skinned
  // positions where it has them. Lag is 0 without a skeleton, and not a number where the frame of a body with
  // one has no skinned positions.
  void fill(const model::Frame& frame, FrameNumbers& numbers) const;

 private:
  const model::Model* model_;
  double rest_volume_ = 0.0;
};

}  // namespace fascicle::studio
