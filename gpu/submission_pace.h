// How much work goes into one submission. None may run for 100 ms: that makes a desktop stutter, and some
// drivers then treat the device as hung and reset it.
#pragma once

#include <cstdint>

namespace fascicle::gpu {

class SubmissionPace {
 public:
  // Initial guess: software devices take a microsecond per vertex and stage, real ones far less. Both guesses
  // are on the slow side. A device without timestamps keeps them.
  explicit SubmissionPace(bool software) : nanoseconds_per_slice_(software ? 32000.0 : 1000.0) {}

  // The number of slices of slice_width items, summed over dispatches, allowed in one submission; at least 1.
  std::uint64_t slices_per_submission() const;

  // Records the time that a submission of `slices` took. Adopts a slower pace at once, a faster one
  // gradually.
  void learn(std::uint64_t slices, double nanoseconds);

 private:
  double nanoseconds_per_slice_;
};

}  // namespace fascicle::gpu
