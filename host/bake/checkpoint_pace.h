// When a bake makes its frames durable: so often that a power cut takes no more than a stated time's work,
// and no oftener than that.
#pragma once

#include <cstdint>

namespace fascicle::bake {

// Times are seconds of one clock.
class CheckpointPace {
 public:
  // A checkpoint is due at frame `last`, after every `most_frames` frames, and before `most_seconds` are over
  // since the one before. At least one frame lies between two.
  CheckpointPace(std::uint64_t last, std::uint64_t most_frames, double most_seconds, double now)
      : last_(last),
        most_frames_(most_frames),
        most_seconds_(most_seconds),
        taken_(now),
        frame_ended_(now),
        frame_seconds_(most_seconds) {}

  // Whether the state after `frame`, which is under way, is to be kept: the next one would come too late.
  // `seconds_to_sync`: that the disk took for the checkpoint before. A slow disk is waited for at most half
  // of the time.
  bool is_due(std::uint64_t frame, double now, double seconds_to_sync) const;
  void frame_has_ended(double now);
  // A checkpoint is taken of the state at this time.
  void is_taken(double now) { taken_ = now; }

 private:
  std::uint64_t last_, most_frames_;
  double most_seconds_, taken_, frame_ended_;
  double frame_seconds_;  // of the last one; the first may be a long one
};

}  // namespace fascicle::bake
