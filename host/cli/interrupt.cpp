#include "host/cli/interrupt.h"

#include <array>

#include <signal.h>
#include <unistd.h>

#include "host/cli/exit_codes.h"

namespace fascicle::cli {
namespace {

constexpr std::array stop_signals{SIGINT, SIGTERM};

// The only global state of the process, because a signal handler takes no argument of ours.
struct SignalState {
  std::atomic<bool> interrupted{false}, has_begun{true};
  std::atomic<int> first_number{0};  // of the signal; 0: none came
};
SignalState signal_state;
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free,
              "a signal handler may only touch lock-free atomics");

void on_signal(int number) {
  if (!signal_state.has_begun) ::_exit(static_cast<int>(ExitCode::interrupted));
  signal_state.interrupted = true;
  // After a hangup, which may come first, the program is still given time to end.
  if (signal_state.first_number.exchange(number) != 0) {
    ::signal(number, SIG_DFL);
    ::raise(number);
  }
}

void on_hangup(int) {
  signal_state.interrupted = true;
}

void handle(int number, void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  ::sigemptyset(&action.sa_mask);
  // Restart interrupted writes of frames: a signal ends the loop, not a write.
  action.sa_flags = SA_RESTART;
  struct sigaction before {};
  // A job started with the signal ignored (nohup, a shell's background job) keeps ignoring it.
  if (::sigaction(number, nullptr, &before) == 0 && before.sa_handler != SIG_IGN)
    ::sigaction(number, &action, nullptr);
  // The parent process may have blocked it.
  sigset_t set;
  ::sigemptyset(&set);
  ::sigaddset(&set, number);
  ::sigprocmask(SIG_UNBLOCK, &set, nullptr);
}

}  // namespace

void catch_interrupts() {
  // A parent that ignores the ends of its children passes that on; the ends of ours would then never be seen.
  ::signal(SIGCHLD, SIG_DFL);
  for (const int number : stop_signals) handle(number, on_signal);
}

void catch_hangups() {
  handle(SIGHUP, on_hangup);
}

const std::atomic<bool>& interrupts() {
  signal_state.has_begun = true;
  return signal_state.interrupted;
}

void end_at_once_until_asked() {
  signal_state.has_begun = false;
}

void let_interrupts_end_the_process() {
  for (const int number : stop_signals) {
    struct sigaction before {};
    if (::sigaction(number, nullptr, &before) == 0 && before.sa_handler == on_signal)
      ::signal(number, SIG_DFL);
  }
  if (const int number = signal_state.first_number; number != 0) ::raise(number);
}

}  // namespace fascicle::cli
