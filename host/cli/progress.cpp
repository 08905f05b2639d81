#include "host/cli/progress.h"

#include <utility>

namespace fascicle::cli {
namespace {

constexpr std::chrono::duration<double> between_bars{0.1};
constexpr std::chrono::duration<double> between_lines{3.0};

}  // namespace

Progress::Progress(Log& log, std::string what, std::uint64_t total)
    : log_(log), what_(std::move(what)), total_(total), start_(Clock::now()), shown_(start_) {}

Progress::~Progress() {
  log_.clear_bar();
}

void Progress::update(std::uint64_t done) {
  const Clock::time_point now = Clock::now();
  const bool is_first = !started_;
  if (is_first) {
    // Time before the first frame (allocation, the driver's compilation, everything before frame 0) does not
    // predict the others.
    started_ = true;
    first_ = done;
    start_ = now;
  }
  const std::chrono::duration<double> since_shown = now - shown_;
  if (since_shown < (log_.draws_bar() ? between_bars : between_lines) && done != total_ && !is_first) return;
  shown_ = now;

  Advance advance{.what = what_, .done = done, .total = total_, .rate = 0.0, .seconds_left = -1.0};
  const double seconds = std::chrono::duration<double>(now - start_).count();
  if (done > first_ && seconds > 0.0) {
    advance.rate = static_cast<double>(done - first_) / seconds;
    advance.seconds_left = static_cast<double>(total_ - done) / advance.rate;
  }
  log_.progress(advance);
}

}  // namespace fascicle::cli
