#include "host/base/process.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <ctime>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <linux/close_range.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host/base/descriptor.h"

namespace fascicle::base {
namespace {

using Clock = std::chrono::steady_clock;

[[noreturn]] void throw_error(int error, const std::string& what) {
  throw std::system_error(error, std::generic_category(), what);
}

// Everything the child needs, prepared before fork(): between fork() and exec() nothing may allocate.
struct Launch {
  const char* program;
  char* const* arguments;
  int error_output;  // becomes stderr
  int report;        // receives errno if exec() fails
  pid_t parent;
  std::optional<rlimit> memory, processor, core;
};

bool limit(decltype(RLIMIT_AS) resource, const std::optional<rlimit>& to) {
  return !to || ::setrlimit(resource, &*to) == 0;
}

[[noreturn]] void start_child(const Launch& launch) {
  const auto give_up = [&] {
    const int error = errno;
    [[maybe_unused]] const ssize_t written = ::write(launch.report, &error, sizeof error);
    ::_exit(127);
  };
  ::setpgid(0, 0);
  if (::prctl(PR_SET_PDEATHSIG, SIGKILL) != 0) give_up();
  if (::getppid() != launch.parent) ::_exit(127);  // the parent died before prctl()
  sigset_t none;
  sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  for (const int number : {SIGPIPE, SIGINT, SIGTERM, SIGHUP, SIGXCPU, SIGCHLD}) ::signal(number, SIG_DFL);
  const int null = ::open("/dev/null", O_RDWR);
  if (null < 0 || ::dup2(null, STDIN_FILENO) < 0 || ::dup2(null, STDOUT_FILENO) < 0 ||
      ::dup2(launch.error_output == no_output ? null : launch.error_output, STDERR_FILENO) < 0) {
    give_up();
  }
  // Libraries open descriptors that survive exec(): a helper must not reach the studio's sockets. Kernels
  // before 5.11 do not know the flag.
#ifdef CLOSE_RANGE_CLOEXEC
  ::close_range(STDERR_FILENO + 1, ~0U, CLOSE_RANGE_CLOEXEC);
#endif
  if (!limit(RLIMIT_CORE, launch.core) || !limit(RLIMIT_CPU, launch.processor) ||
      !limit(RLIMIT_AS, launch.memory)) {
    give_up();
  }
  ::execv(launch.program, launch.arguments);
  give_up();
  ::_exit(127);
}

// Arguments for exec(); valid as long as `words` is.
std::vector<char*> pointers_to(std::vector<std::string>& words) {
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return pointers;
}

// errno of a child that failed to exec, else 0. Waits until it has succeeded or failed.
int error_of_launch(const Descriptor& report) {
  int error = 0;
  ssize_t reported = 0;
  do {
    reported = ::read(report.get(), &error, sizeof error);  // returns when exec() closes the child's end
  } while (reported < 0 && errno == EINTR);
  return reported == static_cast<ssize_t>(sizeof error) ? error : 0;
}

pid_t start(const Launch& launch) {
  const pid_t child = ::fork();
  if (child < 0) throw_error(errno, "fork");
  if (child == 0) start_child(launch);
  ::setpgid(child, child);  // in the parent too, because either may run first
  return child;
}

// Our limit, or the current hard limit if that is lower.
rlimit limit_of(decltype(RLIMIT_AS) resource, rlim_t soft, rlim_t hard) {
  rlimit current{};
  if (::getrlimit(resource, &current) != 0) throw_error(errno, "getrlimit");
  return {std::min(soft, current.rlim_max), std::min(hard, current.rlim_max)};
}

// Reads what is available. False at the end of the stream.
bool read_some(int descriptor, std::string& tail) {
  constexpr std::size_t kept = 4096;
  std::array<char, 4096> buffer;
  const ssize_t size = ::read(descriptor, buffer.data(), buffer.size());
  if (size < 0) return errno == EAGAIN || errno == EINTR;
  tail.append(buffer.data(), static_cast<std::size_t>(size));
  if (tail.size() > kept) tail.erase(0, tail.size() - kept);
  return size > 0;
}

// reaped: by other code in this process; the id may be reused.
enum class ChildState { running, ended, reaped };

ChildState state_of(pid_t child) {
  siginfo_t info{};
  // WNOWAIT leaves a zombie, so its process id and group id cannot be reused until it is reaped.
  if (::waitid(P_PID, static_cast<id_t>(child), &info, WEXITED | WNOHANG | WNOWAIT) != 0)
    return errno == ECHILD ? ChildState::reaped : ChildState::running;
  return info.si_pid == child ? ChildState::ended : ChildState::running;
}

// Processor time that a child has used, s; negative if the system does not say.
double processor_seconds(pid_t child) {
  clockid_t clock{};
  timespec used{};
  if (::clock_getcpuclockid(child, &clock) != 0 || ::clock_gettime(clock, &used) != 0) return -1.0;
  return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
}

// Waits until the child ends, runs out of time or is cancelled; `exited` if it ended by itself, in any way.
// Nothing if other code reaped it.
std::optional<ProcessEnd> wait_for_end(pid_t child, int error_output, const ProcessLimits& limits,
                                       std::string& tail) {
  constexpr int slice = 20;  // ms; the end of stderr wakes us at once, so this matters only for a child that
                             // has closed it
  bool is_open = true;
  double used = 0.0;
  Clock::time_point moved = Clock::now();
  for (;;) {
    const ChildState state = state_of(child);
    if (state == ChildState::reaped) return std::nullopt;
    // Before its end is seen, so that a child that has ended already was asked about, too.
    if (limits.is_cancelled && limits.is_cancelled()) return ProcessEnd::cancelled;
    if (state == ChildState::ended) return ProcessEnd::exited;
    if (const double now = processor_seconds(child); now > used) {
      used = now;
      moved = Clock::now();
    }
    if (used > limits.seconds) return ProcessEnd::timed_out;
    if (std::chrono::duration<double>(Clock::now() - moved).count() > limits.seconds)
      return ProcessEnd::stalled;
    pollfd event{is_open ? error_output : -1, POLLIN, 0};
    const int ready = ::poll(&event, 1, slice);
    if (ready > 0) is_open = read_some(error_output, tail);
  }
}

}  // namespace

bool was_killed_from_outside(const ProcessResult& result) {
  constexpr std::array signals{SIGKILL, SIGTERM, SIGHUP, SIGINT};
  return result.end == ProcessEnd::signalled &&
         std::find(signals.begin(), signals.end(), result.code) != signals.end();
}

ProcessResult run_process(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                          const ProcessLimits& limits) {
  auto [error_output, child_error] = make_pipe();
  auto [report, child_report] = make_pipe();
  const std::string name = program.string();
  std::vector<std::string> words = arguments;
  words.insert(words.begin(), name);
  const std::vector<char*> pointers = pointers_to(words);
  const auto seconds = static_cast<rlim_t>(std::ceil(std::clamp(limits.seconds, 0.0, 1e9)));
  Launch launch{};
  launch.program = name.c_str();
  launch.arguments = pointers.data();
  launch.error_output = child_error.get();
  launch.report = child_report.get();
  launch.parent = ::getpid();
  launch.memory = limit_of(RLIMIT_AS, limits.bytes, limits.bytes);
  launch.processor = limit_of(RLIMIT_CPU, seconds + 1, seconds + 2);
  launch.core = rlimit{0, 0};

  const pid_t child = start(launch);
  child_error.close();
  child_report.close();
  const int launch_error = error_of_launch(report);

  ProcessResult result;
  ::fcntl(error_output.get(), F_SETFL, O_NONBLOCK);
  std::optional<ProcessEnd> waited = wait_for_end(child, error_output.get(), limits, result.last_words);
  int status = 0;
  if (waited) {
    ::kill(-child, SIGKILL);
    pid_t reaped = 0;
    do {
      reaped = ::waitpid(child, &status, 0);
    } while (reaped < 0 && errno == EINTR);
    // If we killed it, we still know how it ended.
    if (reaped < 0 && waited == ProcessEnd::exited) waited.reset();
  }
  for (int i = 0; i < 16 && read_some(error_output.get(), result.last_words); ++i) {
  }
  if (launch_error != 0) throw_error(launch_error, name);
  if (!waited)
    throw std::runtime_error(name +
                             ": a child of this process was reaped by others; the program that uses fascicle "
                             "must leave SIGCHLD at its default and not wait for all children");
  if (waited != ProcessEnd::exited) {
    result.end = *waited;
  } else if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU) {
    result.end = ProcessEnd::timed_out;
  } else if (WIFSIGNALED(status)) {
    result.end = ProcessEnd::signalled;
    result.code = WTERMSIG(status);
  } else {
    result.code = WEXITSTATUS(status);
  }
  return result;
}

pid_t start_process(const std::vector<std::string>& arguments, int error_output) {
  auto [report, child_report] = make_pipe();
  std::vector<std::string> words = arguments;
  const std::vector<char*> pointers = pointers_to(words);
  Launch launch{};
  launch.program = pointers.front();
  launch.arguments = pointers.data();
  launch.error_output = error_output;
  launch.report = child_report.get();
  launch.parent = ::getpid();
  const pid_t child = start(launch);
  child_report.close();
  if (const int error = error_of_launch(report); error != 0) {
    ::waitpid(child, nullptr, 0);
    throw_error(error, arguments.front());
  }
  return child;
}

}  // namespace fascicle::base
