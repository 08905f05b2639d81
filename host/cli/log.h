// What is said on stderr while a command runs. Results go to stdout and never through here.
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

// How far a long piece of work has come.
struct Advance {
  std::string what;  // "baking"
  std::uint64_t done = 0, total = 0;
  double rate = 0.0;          // frames a second; 0 while unknown
  double seconds_left = 0.0;  // negative while unknown
};

// In text, one line a message; in JSON, one object a line with the members time (s since the start), level
// and message, and for level "progress" frame, frames, rate and eta. In openjd as in text, with what a farm
// that speaks Open Job Description looks for: openjd_progress (percent), openjd_status, and openjd_fail of an
// error. Errors are always shown, warnings and information not under quiet, details only under verbose.
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

  // On a terminal redraws one line; elsewhere and in JSON adds one, so call it seldom there (see draws_bar).
  void progress(const Advance& advance);
  // The same of work that is no count of frames: one line that tells how things stand. May be called often:
  // where it draws no bar it says what is new every few seconds.
  void state(const std::string& text);
  // The share of the whole that is done, for a farm; nothing in text and in JSON. May be called often.
  void share(double done);
  // Takes the bar away, if there is one.
  void clear_bar();
  // True where progress redraws a line in place: text on a terminal that can.
  bool draws_bar() const { return bar_allowed_; }

 private:
  void draw(const std::string& state);
  void line(const char* level, const std::string& prefix, const std::string& message);

  LogOptions options_;
  bool bar_allowed_ = false, colour_ = false;
  std::size_t bar_width_ = 0;  // characters of the bar now on the terminal
  std::chrono::steady_clock::time_point start_, stated_, shared_;
  std::string last_state_;
};

// What host/pipeline has to say, on this log, which must outlive it.
pipeline::Say say_on(Log& log);

// "baking  [######------]  50 %  frame 60/120  35.1 frames/s  1.71 s left"; without the bar if `width` is 0.
std::string advance_text(const Advance& advance, unsigned width);

}  // namespace fascicle::cli
