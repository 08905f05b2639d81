// How much work goes into one submission: little enough that none runs for 100 ms, which would make a desktop
// stutter and, on some systems, have the driver give the device up for hung.
#pragma once

#include <cstdint>

namespace fascicle::gpu {

class SubmissionPace {
 public:
  // The first guess: software devices take a microsecond a vertex and stage, real ones far less. Both are
  // rather too slow than too fast. A device without timestamps keeps them.
  explicit SubmissionPace(bool software) : nanoseconds_per_slice_(software ? 32000.0 : 1000.0) {}

  // Slices of slice_width items, summed over dispatches, that one submission may hold; at least 1.
  std::uint64_t slices_per_submission() const;

  // A submission of `slices` took so long. A slower pace is taken at once, a faster one gradually.
  void learn(std::uint64_t slices, double nanoseconds);

 private:
  double nanoseconds_per_slice_;
};

}  // namespace fascicle::gpu
