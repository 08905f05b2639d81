#include "host/bake/checkpoint_pace.h"

namespace fascicle::bake {

bool CheckpointPace::is_due(std::uint64_t frame, double now, double seconds_to_sync) const {
  if (frame == last_ || frame % most_frames_ == 0) return true;
  // Two frames are simulated before the next opportunity: this one and the next.
  const double lost = now - taken_ + 2.0 * frame_seconds_ + seconds_to_sync;
  return lost >= most_seconds_ && now - taken_ + frame_seconds_ >= seconds_to_sync;
}

void CheckpointPace::frame_has_ended(double now) {
  frame_seconds_ = now - frame_ended_;
  frame_ended_ = now;
}

}  // namespace fascicle::bake
