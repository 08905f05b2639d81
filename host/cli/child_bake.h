// A bake in a process of its own, heard through its log.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <sys/types.h>

#include "host/base/descriptor.h"

namespace fascicle::cli {

// A line of our own log, as --log-format json writes it.
struct LogLine {
  std::string level, message;
  std::optional<std::uint64_t> frame, frames;  // of progress
};
// Nothing where the line is none: what drivers and libraries write is theirs, be it JSON or not.
std::optional<LogLine> read_log_line(const std::string& line);

class ChildBake {
 public:
  // Runs this executable with these arguments and `--log-format json`. It does not outlive this process, also
  // where that is killed. Throws std::system_error.
  explicit ChildBake(std::vector<std::string> arguments);
  // Kills it where it still runs.
  ~ChildBake();
  ChildBake(const ChildBake&) = delete;
  ChildBake& operator=(const ChildBake&) = delete;

  // To poll() for what it says; -1 once it has closed it.
  int descriptor() const { return descriptor_.get(); }
  // Takes in what it has said.
  void listen();
  // As on ctrl-C: it ends after the frame it is at. Its own group keeps the terminal's from it.
  void interrupt();
  // Whether it is over; then status() is its exit status, that of a signal 128 + its number.
  bool has_ended();
  int status() const { return status_; }

  pid_t process() const { return process_; }
  std::uint64_t frame() const { return frame_; }
  std::uint64_t frames() const { return frames_; }
  // Its last error, else empty.
  const std::string& error() const { return error_; }
  const std::vector<std::string>& warnings() const { return warnings_; }
  // Lines on its stderr that are not of its log, since the last call.
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
