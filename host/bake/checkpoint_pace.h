// Decides when a bake makes its frames durable: often enough that a power cut costs at most a stated time's
// work, and no more often.
#pragma once

#include <cstdint>

namespace fascicle::bake {

// Times are seconds on one clock.
class CheckpointPace {
 public:
  // A checkpoint is due at frame `last`, after every `most_frames` frames, and before `most_seconds` have
  // passed since the last one. There is at least one frame between two checkpoints.
  CheckpointPace(std::uint64_t last, std::uint64_t most_frames, double most_seconds, double now)
      : last_(last),
        most_frames_(most_frames),
        most_seconds_(most_seconds),
        taken_(now),
        frame_ended_(now),
        frame_seconds_(most_seconds) {}

  // Whether to checkpoint the state after `frame`, which is being simulated, because after the next one would
  // be too late. `seconds_to_sync`: the disk's time for the last checkpoint. Syncing to a slow disk takes at
  // most half of the time.
  bool is_due(std::uint64_t frame, double now, double seconds_to_sync) const;
  void frame_has_ended(double now);
  // The state at this time is being checkpointed.
  void is_taken(double now) { taken_ = now; }

 private:
  std::uint64_t last_, most_frames_;
  double most_seconds_, taken_, frame_ended_;
  double frame_seconds_;  // of the last one; until then most_seconds, as the first may be long
};

}  // namespace fascicle::bake
