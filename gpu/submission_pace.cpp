#include "gpu/submission_pace.h"

#include <algorithm>

namespace fascicle::gpu {
namespace {

// Half of the 100 ms limit for a submission: stages cost different amounts, and machines slow down.
constexpr double target_nanoseconds = 50e6;
// Below this, a submission's fixed costs dominate, unless the pace allows no more.
constexpr std::uint64_t fewest_slices_to_learn_from = 64;

}  // namespace

std::uint64_t SubmissionPace::slices_per_submission() const {
  // 2^40 slices are more than any buffer holds, and far below where the conversion would overflow.
  return static_cast<std::uint64_t>(std::clamp(target_nanoseconds / nanoseconds_per_slice_, 1.0, 0x1p40));
}

void SubmissionPace::learn(std::uint64_t slices, double nanoseconds) {
  // Without the second bound, a pace that one stall made slow would never recover: no submission would be
  // large enough.
  if (slices < std::min(fewest_slices_to_learn_from, slices_per_submission())) return;
  const double measured = nanoseconds / static_cast<double>(slices);
  nanoseconds_per_slice_ = std::max({measured, 0.75 * nanoseconds_per_slice_, 1e-3});
}

}  // namespace fascicle::gpu
