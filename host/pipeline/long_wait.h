// Progress messages for work that shows nothing else.
#pragma once

#include <chrono>
#include <string>

#include "host/pipeline/messages.h"

namespace fascicle::pipeline {

// Reports what is still running: first after `first`, then whenever the elapsed time has doubled.
class LongWait {
 public:
  explicit LongWait(Say say, std::chrono::duration<double> first = std::chrono::seconds(5));

  // Call repeatedly during the work; `what` as in "still building the body".
  void go_on(const std::string& what);

 private:
  using Clock = std::chrono::steady_clock;

  Say say_;
  Clock::time_point start_;
  std::chrono::duration<double> due_;
};

}  // namespace fascicle::pipeline
