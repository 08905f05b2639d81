#include "host/pipeline/long_wait.h"

#include <utility>

#include "host/pipeline/text.h"

namespace fascicle::pipeline {

LongWait::LongWait(Say say, std::chrono::duration<double> first)
    : say_(std::move(say)), start_(Clock::now()), due_(first) {}

void LongWait::go_on(const std::string& what) {
  const std::chrono::duration<double> gone = Clock::now() - start_;
  if (gone < due_) return;
  say_info(say_, what + ": " + duration_text(gone.count()) + " so far");
  due_ = 2.0 * gone;
}

}  // namespace fascicle::pipeline
