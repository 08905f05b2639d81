#include "host/cli/interrupt.h"

#include <signal.h>

namespace fascicle::cli {
namespace {

// A signal handler takes no argument of ours: the one place where the process keeps state.
std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may only touch lock-free atomics");

void on_signal(int number) {
  if (interrupted.exchange(true)) {
    ::signal(number, SIG_DFL);
    ::raise(number);
  }
}

}  // namespace

const std::atomic<bool>& catch_interrupts() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  ::sigemptyset(&action.sa_mask);
  // Writes of frames go on: a signal asks for the end of the loop, not for half a write.
  action.sa_flags = SA_RESTART;
  for (const int number : {SIGINT, SIGTERM}) {
    struct sigaction before {};
    // A job started with the signal ignored (nohup, a shell's background job) keeps ignoring it.
    if (::sigaction(number, nullptr, &before) == 0 && before.sa_handler != SIG_IGN)
      ::sigaction(number, &action, nullptr);
  }
  return interrupted;
}

}  // namespace fascicle::cli
