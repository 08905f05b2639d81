// Messages on stderr while a command runs. Results go to stdout instead.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "host/pipeline/messages.h"

namespace fascicle::cli {

enum class Verbosity { quiet, normal, verbose };
enum class LogFormat { text, json, openjd };

struct LogOptions {
  Verbosity verbosity = Verbosity::normal;
  LogFormat format = LogFormat::text;
};

// Progress of a long operation.
struct Advance {
  std::string what;  // "baking"
  std::uint64_t done = 0, total = 0;
  double rate = 0.0;          // frames per second; 0 if unknown
  double seconds_left = 0.0;  // negative if unknown
};

// Text: one line per message. JSON: one object per line with time (s since the start), level and message, and
// for level "progress" also frame, frames, rate and eta. openjd: text plus the lines that farms with Open Job
// Description parse: openjd_progress (percent), openjd_status, and openjd_fail for an error. Errors are
// always shown, warnings and information unless quiet, details only if verbose.
class Log {
 public:
  explicit Log(const LogOptions& options);
  ~Log();
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;

  void error(const std::string& message);
  void warning(const std::string& message);
  void info(const std::string& message);
  void detail(const std::string& message);

  // Redraws one line on a terminal. Elsewhere and in JSON it adds a line, so call it rarely then (see
  // draws_bar).
  void progress(const Advance& advance);
  // The same for work without a frame count: one line of status. May be called often: without a bar, it
  // prints changes every few seconds.
  void state(const std::string& text);
  // The completed share of the whole, for a farm; no output in text and JSON. May be called often.
  void share(double done);
  // Removes the bar, if there is one.
  void clear_bar();
  // Whether progress redraws a line in place: text on a capable terminal.
  bool draws_bar() const { return bar_allowed_; }

 private:
  void draw(const std::string& state);
  void line(const char* level, const std::string& prefix, const std::string& message);

  LogOptions options_;
  bool bar_allowed_ = false, colour_ = false;
  std::size_t bar_width_ = 0;  // characters of the bar on the terminal
  std::chrono::steady_clock::time_point start_, stated_, shared_;
  std::string last_state_;
};

// Messages of host/pipeline go to this log, which must outlive the result.
pipeline::Say say_on(Log& log);

// "baking  [######------]  50 %  frame 60/120  35.1 frames/s  1.71 s left"; without the bar if `width` is 0.
std::string advance_text(const Advance& advance, unsigned width);

}  // namespace fascicle::cli
