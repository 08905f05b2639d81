// Programs that run under limits, even if SIGCHLD is not at its default in the process that starts them.
#include "host/base/process.h"

#include <array>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/close_range.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

namespace fascicle::tests {
namespace {

using base::ProcessEnd;
using base::run_process;

// Sets the disposition of SIGCHLD; restores it on destruction.
class ChildSignal {
 public:
  ChildSignal(void (*handler)(int), int flags) {
    struct sigaction action {};
    action.sa_handler = handler;
    action.sa_flags = flags;
    ::sigaction(SIGCHLD, &action, &before_);
  }
  ~ChildSignal() { ::sigaction(SIGCHLD, &before_, nullptr); }
  ChildSignal(const ChildSignal&) = delete;
  ChildSignal& operator=(const ChildSignal&) = delete;

 private:
  struct sigaction before_ {};
};

std::string refusal() {
  try {
    run_process("/bin/sh", {"-c", "exit 3"}, {.seconds = 5.0});
  } catch (const std::system_error& error) {
    return std::string("a system_error, as if it had not been started: ") + error.what();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "no error";
}

TEST(Process, TellsHowItEnded) {
  const ChildSignal as_usual(SIG_DFL, 0);
  const auto result = run_process("/bin/sh", {"-c", "echo why >&2; exit 3"}, {.seconds = 5.0});
  EXPECT_EQ(result.end, ProcessEnd::exited);
  EXPECT_EQ(result.code, 3);
  EXPECT_EQ(result.last_words, "why\n");
}

// Whatever the process has open, also through libraries that do not close it on exec.
TEST(Process, InheritsNoDescriptor) {
#ifndef CLOSE_RANGE_CLOEXEC
  GTEST_SKIP() << "SKIPPED, NOT TESTED: this system has no close_range()";
#else
  // Here nothing is in this range: the call only says whether the kernel knows the flag.
  if (::close_range(~0U - 1, ~0U, CLOSE_RANGE_CLOEXEC) != 0)
    GTEST_SKIP() << "SKIPPED, NOT TESTED: this kernel does not mark descriptors, or a filter forbids it";
  const ChildSignal as_usual(SIG_DFL, 0);
  const int open = ::open("/dev/null", O_RDONLY);  // as a library does, without O_CLOEXEC
  ASSERT_GT(open, STDERR_FILENO);
  const std::string script = "test -e /proc/$$/fd/" + std::to_string(open) + " || echo closed >&2";
  const auto result = run_process("/bin/sh", {"-c", script}, {.seconds = 5.0});
  EXPECT_EQ(std::system(("set -- " + std::to_string(open) + "; test -e /proc/$$/fd/$1").c_str()), 0)
      << "the control: others inherit it";
  ::close(open);
  EXPECT_EQ(result.last_words, "closed\n");
#endif
}

TEST(Process, EndsAtOnceWhereItIsCancelled) {
  const ChildSignal as_usual(SIG_DFL, 0);
  int asked = 0;
  const auto began = std::chrono::steady_clock::now();
  const auto result =
      run_process("/bin/sleep", {"60"}, {.seconds = 60.0, .is_cancelled = [&] { return ++asked > 5; }});
  EXPECT_EQ(result.end, ProcessEnd::cancelled);
  EXPECT_EQ(asked, 6) << "is_cancelled was called again after it returned true";
  // It polls every 20 ms; the rest is slack for a busy machine.
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(20));
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1) << "a child was not reaped";
  // The control: is_cancelled returning false changes nothing.
  const auto whole =
      run_process("/bin/sh", {"-c", "exit 3"}, {.seconds = 5.0, .is_cancelled = [] { return false; }});
  EXPECT_EQ(whole.end, ProcessEnd::exited);
  EXPECT_EQ(whole.code, 3);
}

// The process state: R, S and so on. Z for a zombie or if the process is gone.
char state_of(pid_t process) {
  std::ifstream in("/proc/" + std::to_string(process) + "/stat");
  std::string line;
  std::getline(in, line);
  const std::size_t name = line.rfind(')');
  return name == std::string::npos || name + 2 >= line.size() ? 'Z' : line[name + 2];
}

TEST(Process, DoesNotOutliveWhoeverStartedIt) {
  std::array<int, 2> pipe{};
  ASSERT_EQ(::pipe(pipe.data()), 0);
  const pid_t parent = ::fork();
  if (parent == 0) {
    const pid_t child = base::start_process({"/bin/sleep", "600"}, STDERR_FILENO);
    if (::write(pipe[1], &child, sizeof child) != sizeof child) ::_exit(1);
    ::pause();
  }
  pid_t child = 0;
  ASSERT_EQ(::read(pipe[0], &child, sizeof child), static_cast<ssize_t>(sizeof child));
  EXPECT_NE(state_of(child), 'Z');
  ::kill(parent, SIGKILL);
  ::waitpid(parent, nullptr, 0);
  // By itself it would run for ten minutes.
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (state_of(child) != 'Z' && std::chrono::steady_clock::now() < end) ::usleep(1000);
  EXPECT_EQ(state_of(child), 'Z');
  if (state_of(child) != 'Z') ::kill(child, SIGKILL);
  ::close(pipe[0]);
  ::close(pipe[1]);
}

// The kernel then reaps children itself, and their exit status is lost.
TEST(Process, SaysWhereOthersReapItsChildren) {
  for (const bool ignored : {true, false}) {
    const ChildSignal lost(ignored ? SIG_IGN : SIG_DFL, ignored ? 0 : SA_NOCLDWAIT);
    EXPECT_NE(refusal().find("must leave SIGCHLD at its default"), std::string::npos) << refusal();
    EXPECT_THROW(run_process("/no/such/program", {}, {.seconds = 5.0}), std::system_error);
    // A result that does not need the exit status is reported as usual.
    EXPECT_EQ(run_process("/bin/sleep", {"60"}, {.seconds = 0.1}).end, ProcessEnd::stalled);
  }
}

}  // namespace
}  // namespace fascicle::tests
