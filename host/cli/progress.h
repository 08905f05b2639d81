// Progress of a run of frames, with its rate and remaining time.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "host/cli/log.h"

namespace fascicle::cli {

// Shows the first and last update, and in between at most ten bars per second on a terminal or a line every
// few seconds elsewhere. The rate counts from the first update, so that frames already finished before a
// resume do not inflate it.
class Progress {
 public:
  Progress(Log& log, std::string what, std::uint64_t total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void update(std::uint64_t done);

 private:
  using Clock = std::chrono::steady_clock;

  Log& log_;
  std::string what_;
  std::uint64_t total_;
  bool started_ = false;
  std::uint64_t first_ = 0;
  Clock::time_point start_, shown_;
};

}  // namespace fascicle::cli
