// A bake in a separate process, followed through its log.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <sys/types.h>

#include "host/base/descriptor.h"

namespace fascicle::cli {

// A line of our own log, in the format of --log-format json.
struct LogLine {
  std::string level, message;
  std::optional<std::uint64_t> frame, frames;  // for progress
};
// nullopt if it is not one. Drivers and libraries may write anything, JSON or not.
std::optional<LogLine> read_log_line(const std::string& line);

class ChildBake {
 public:
  // Runs this executable with these arguments and `--log-format json`. The child does not outlive this
  // process, even if that is killed. Throws std::system_error.
  explicit ChildBake(std::vector<std::string> arguments);
  // Kills the child if it is still running.
  ~ChildBake();
  ChildBake(const ChildBake&) = delete;
  ChildBake& operator=(const ChildBake&) = delete;

  // For poll(), to wait for output; -1 once the child has closed it.
  int descriptor() const { return descriptor_.get(); }
  // Reads its pending output.
  void listen();
  // Like Ctrl-C: the child stops after its current frame. It has its own process group, so the terminal's
  // Ctrl-C does not reach it.
  void interrupt();
  // Whether it has ended. Then status() is its exit status, or 128 + the number of the signal that ended it.
  bool has_ended();
  int status() const { return status_; }

  pid_t process() const { return process_; }
  std::uint64_t frame() const { return frame_; }
  std::uint64_t frames() const { return frames_; }
  // Its last error message; empty if none.
  const std::string& error() const { return error_; }
  const std::vector<std::string>& warnings() const { return warnings_; }
  // Lines on its stderr since the last call that are not from its log.
  std::vector<std::string> take_other_lines() { return std::exchange(other_lines_, {}); }

 private:
  void take_line(const std::string& line);

  pid_t process_ = -1;
  base::Descriptor descriptor_;
  bool ended_ = false, interrupted_ = false;
  int status_ = 0;
  std::uint64_t frame_ = 0, frames_ = 0, other_count_ = 0;
  std::string unread_, error_;
  std::vector<std::string> warnings_, other_lines_;
};

}  // namespace fascicle::cli
