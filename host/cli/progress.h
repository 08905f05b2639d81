// Progress of a run of frames, with its rate and the time that is left.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "host/cli/log.h"

namespace fascicle::cli {

// Shows the first update and the last one, and between them at most ten bars a second on a terminal and one
// line every few seconds elsewhere. The rate counts from the first update, so that the frames a resumed bake
// finds done do not flatter it.
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
