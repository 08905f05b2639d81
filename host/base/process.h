// Runs a program under limits and survives whatever it does.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <sys/types.h>

namespace fascicle::base {

struct ProcessLimits {
  // Limits processor time, so that a busy machine does no harm, and wall-clock time during which no processor
  // time is used.
  double seconds = 60.0;
  std::uint64_t bytes = std::uint64_t{4} << 30;  // of address space
  // Called at least fifty times a second while the program runs, and at least once; returning true ends the
  // program. Must not throw.
  std::function<bool()> is_cancelled = {};
};

enum class ProcessEnd { exited, signalled, timed_out, stalled, cancelled };

struct ProcessResult {
  ProcessEnd end = ProcessEnd::exited;
  int code = 0;            // exit status, or the signal's number
  std::string last_words;  // the end of its stderr
};

// Runs `program` (a path, not searched for) with `arguments`; stdin and stdout are /dev/null. When it ends,
// exceeds its processor time, stalls or is cancelled, its whole process group is killed. It leaves no core
// dump and dies with its parent. Throws std::system_error if it cannot be started, and std::runtime_error if
// other code in this process reaped it (SIGCHLD ignored, or a wait for any child), because its result is then
// lost.
ProcessResult run_process(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                          const ProcessLimits& limits);

// Whether a signal ended it that its own faults and its limits do not send, such as that of the system when
// memory runs out.
bool was_killed_from_outside(const ProcessResult& result);

// Starts a program (its path is the first of `arguments`) in a new process group and does not wait for it.
// stdin and stdout are /dev/null, stderr is `error_output` or, with no_output, /dev/null; signals are as a
// shell would leave them. It is killed when the thread that started it ends, however that ends. Throws
// std::system_error.
inline constexpr int no_output = -1;
pid_t start_process(const std::vector<std::string>& arguments, int error_output);

}  // namespace fascicle::base
