// Runs a program of our own under limits, and outlives whatever it does.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <sys/types.h>

namespace fascicle::base {

struct ProcessLimits {
  // Of processor time, so that a busy machine is nobody's fault; and of wall clock while none of it is used.
  double seconds = 60.0;
  std::uint64_t bytes = std::uint64_t{4} << 30;  // of address space
  // Asked at least fifty times a second while it runs; true ends it. Must not throw.
  std::function<bool()> is_cancelled = {};
};

enum class ProcessEnd { exited, signalled, timed_out, stalled, cancelled };

struct ProcessResult {
  ProcessEnd end = ProcessEnd::exited;
  int code = 0;            // exit status, or the signal's number
  std::string last_words;  // the end of what it wrote to stderr
};

// Runs `program` (a path, not searched for) with `arguments`; stdin and stdout are /dev/null. When it ends,
// its processor time is over, it stands still or it is cancelled, its whole process group is killed. It gets
// no core dump and dies with its parent. Throws std::system_error if it cannot be started, and
// std::runtime_error if somebody else of this process reaped it (SIGCHLD ignored, or a wait for all
// children), for then its end is lost.
ProcessResult run_process(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                          const ProcessLimits& limits);

// Starts a program (its path is the first of `arguments`) in a process group of its own and does not wait for
// it; stdin and stdout are /dev/null, stderr is `error_output` or, by no_output, /dev/null, signals are as a
// shell would have them. It is killed when the thread that started it ends, however that ends. Throws
// std::system_error.
inline constexpr int no_output = -1;
pid_t start_process(const std::vector<std::string>& arguments, int error_output);

}  // namespace fascicle::base
