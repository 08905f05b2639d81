// Words for a wait of which nothing else is shown.
#pragma once

#include <chrono>
#include <string>

#include "host/pipeline/messages.h"

namespace fascicle::pipeline {

// Says what is still being done: first after `first`, then each time when as long again has gone by.
class LongWait {
 public:
  explicit LongWait(Say say, std::chrono::duration<double> first = std::chrono::seconds(5));

  // To be called again and again while it lasts; `what` as in "still building the body".
  void go_on(const std::string& what);

 private:
  using Clock = std::chrono::steady_clock;

  Say say_;
  Clock::time_point start_;
  std::chrono::duration<double> due_;
};

}  // namespace fascicle::pipeline
