// The player's source of frames: a live simulation or a bake.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/scene/solids.h"
#include "host/studio/wire.h"

namespace fascicle::studio {

// A frame ready to be shown. It points into its motion and is valid until the motion is asked for another.
struct ShownFrame {
  const model::Model* model = nullptr;
  const model::Frame* frame = nullptr;  // positions; skinned positions and velocities if available
  FrameNumbers numbers;                 // all but the sequence, the rate and the body's number
};

// Positions are no longer finite. The motion has restarted from the skeleton.
struct Diverged : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// The interface between the player and what it plays. All calls come from the player's thread.
struct Motion {
  virtual ~Motion() = default;
  virtual std::uint64_t frames() const = 0;  // number of the last frame
  virtual double fps() const = 0;
  virtual double start() const = 0;         // s of the clip at frame 0
  virtual std::uint64_t frame() const = 0;  // the current one
  // The next frame. The clip repeats: after the last frame comes frame 1. Throws Diverged.
  virtual ShownFrame advance() = 0;
  virtual ShownFrame seek(std::uint64_t frame) = 0;
  // Starts at frame 0, after the lead-in; `stop` can end the lead-in early.
  virtual ShownFrame restart(const std::function<bool()>& stop) = 0;
  // The current frame again.
  virtual ShownFrame again() = 0;
  // The joints' positions in the current frame, m, 3 numbers each.
  virtual std::vector<float> joints() = 0;
  // The scene's solids in the current frame, m, in the scene's order; empty if the scene is not known.
  virtual std::vector<scene::Solid> solids() = 0;
};

}  // namespace fascicle::studio
