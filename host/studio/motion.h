// What the player plays: flesh in motion, or the frames of a bake.
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

// A frame as it can be shown. It points into its motion and stands until that is asked for the next one.
struct ShownFrame {
  const model::Model* model = nullptr;
  const model::Frame* frame = nullptr;  // positions, and what there is of skinned and velocities
  FrameNumbers numbers;                 // all but the sequence, the rate and the number of the body
};

// The positions are no longer finite numbers. The motion has begun again on the skeleton.
struct Diverged : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// The seam between the player and what it plays. All calls come from the player's thread.
struct Motion {
  virtual ~Motion() = default;
  virtual std::uint64_t frames() const = 0;  // the last frame's number
  virtual double fps() const = 0;
  virtual double start() const = 0;         // s of the clip at frame 0
  virtual std::uint64_t frame() const = 0;  // the one that is shown
  // The next frame; after the last one frame 1, as the clip begins again. Throws Diverged.
  virtual ShownFrame advance() = 0;
  virtual ShownFrame seek(std::uint64_t frame) = 0;
  // From frame 0, with what comes before it; that ends early where `stop` says so.
  virtual ShownFrame restart(const std::function<bool()>& stop) = 0;
  // The frame that is shown, once more.
  virtual ShownFrame again() = 0;
  // The joints' places in the frame that is shown, m, 3 numbers each.
  virtual std::vector<float> joints() = 0;
  // The scene's solids there, m, in the scene's order; nothing where the scene is not known.
  virtual std::vector<scene::Solid> solids() = 0;
};

}  // namespace fascicle::studio
