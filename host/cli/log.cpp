#include "host/cli/log.h"

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include "host/base/display_width.h"
#include "host/cli/exit_codes.h"
#include "host/cli/text.h"

namespace fascicle::cli {
namespace {

constexpr unsigned bar_cells = 24;
constexpr std::chrono::seconds between_states{3}, between_shares{1};

// One write per line, so that processes that share a stderr do not mix their lines. If its reader has ended,
// nothing more is said, but the work goes on: the signal of a broken pipe would end it.
void put(const std::string& text) {
  sigset_t broken_pipe, before;
  sigemptyset(&broken_pipe);
  sigaddset(&broken_pipe, SIGPIPE);
  pthread_sigmask(SIG_BLOCK, &broken_pipe, &before);
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
  const timespec at_once{};
  while (sigtimedwait(&broken_pipe, nullptr, &at_once) == SIGPIPE) {
  }
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

std::string json_line(const nlohmann::ordered_json& object) {
  // Paths are bytes and need not be UTF-8; a log line must still be JSON. Escaped, because a terminal would
  // execute some characters of names.
  return object.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

// Libraries end their messages with a line break.
std::string without_line_end(std::string message) {
  while (!message.empty() && (message.back() == '\n' || message.back() == '\r')) message.pop_back();
  return message;
}

bool is_set(const char* variable) {
  const char* value = std::getenv(variable);
  return value != nullptr && *value != '\0';
}

}  // namespace

Log::Log(const LogOptions& options) : options_(options), start_(std::chrono::steady_clock::now()) {
  const char* terminal = std::getenv("TERM");
  const bool capable =
      ::isatty(STDERR_FILENO) != 0 && terminal != nullptr && std::strcmp(terminal, "dumb") != 0;
  bar_allowed_ = capable && options.format == LogFormat::text && options.verbosity != Verbosity::quiet;
  colour_ = capable && options.format == LogFormat::text && !is_set("NO_COLOR");
}

Log::~Log() {
  clear_bar();
}

void Log::line(const char* level, const std::string& prefix, const std::string& message) {
  clear_bar();
  const std::string whole = without_line_end(message);
  if (options_.format == LogFormat::json) {
    const std::chrono::duration<double> since = std::chrono::steady_clock::now() - start_;
    put(json_line({{"time", since.count()}, {"level", level}, {"message", whole}}));
    return;
  }
  // Names from files may contain control characters, which a terminal would execute.
  const std::string text = shown_text(whole);
  const bool is_state = std::strcmp(level, "progress") == 0;
  if (options_.format == LogFormat::openjd && is_state)
    put("openjd_status: " + text + "\n");
  else if (options_.format == LogFormat::openjd && std::strcmp(level, "error") == 0)
    put("openjd_fail: " + text + "\n");
  else
    put(prefix + text + "\n");
}

void Log::error(const std::string& message) {
  line("error", colour_ ? "fascicle: \x1b[1;31merror:\x1b[0m " : "fascicle: error: ", message);
}

void Log::warning(const std::string& message) {
  if (options_.verbosity == Verbosity::quiet) return;
  line("warning", colour_ ? "fascicle: \x1b[1;33mwarning:\x1b[0m " : "fascicle: warning: ", message);
}

void Log::info(const std::string& message) {
  if (options_.verbosity != Verbosity::quiet) line("info", "", message);
}

void Log::detail(const std::string& message) {
  if (options_.verbosity == Verbosity::verbose) line("detail", "", message);
}

void Log::progress(const Advance& advance) {
  if (options_.verbosity == Verbosity::quiet) return;
  if (options_.format == LogFormat::json) {
    const std::chrono::duration<double> since = std::chrono::steady_clock::now() - start_;
    nlohmann::ordered_json object{{"time", since.count()},      {"level", "progress"},
                                  {"message", advance.what},    {"frame", advance.done},
                                  {"frames", advance.total},    {"rate", advance.rate},
                                  {"eta", advance.seconds_left}};
    if (advance.rate <= 0.0) object["rate"] = nullptr;
    if (advance.seconds_left < 0.0) object["eta"] = nullptr;
    put(json_line(object));
    return;
  }
  if (options_.format == LogFormat::openjd) {
    line("progress", "", advance_text(advance, 0));
    shared_ = {};
    share(advance.total == 0 ? 1.0 : static_cast<double>(advance.done) / static_cast<double>(advance.total));
    return;
  }
  if (!bar_allowed_) {
    line("progress", "", advance_text(advance, 0));
    return;
  }
  draw(advance_text(advance, bar_cells));
}

void Log::draw(const std::string& state) {
  const std::string text = shown_text(state);
  const std::size_t length = base::display_width(text);
  const std::size_t rest = bar_width_ > length ? bar_width_ - length : 0;
  put("\r" + text + std::string(rest, ' '));
  bar_width_ = length;
}

void Log::state(const std::string& text) {
  if (options_.verbosity == Verbosity::quiet || text == last_state_) return;
  const auto now = std::chrono::steady_clock::now();
  if (!bar_allowed_ && !last_state_.empty() && now - stated_ < between_states) return;
  stated_ = now;
  last_state_ = text;
  if (bar_allowed_)
    draw(text);
  else
    line("progress", "", text);
}

void Log::share(double done) {
  if (options_.verbosity == Verbosity::quiet || options_.format != LogFormat::openjd) return;
  const auto now = std::chrono::steady_clock::now();
  if (done < 1.0 && now - shared_ < between_shares) return;
  shared_ = now;
  put("openjd_progress: " + number_text(std::clamp(done, 0.0, 1.0) * 100.0) + "\n");
}

void Log::clear_bar() {
  if (bar_width_ == 0) return;
  put("\r" + std::string(bar_width_, ' ') + "\r");
  bar_width_ = 0;
}

std::string advance_text(const Advance& advance, unsigned width) {
  const double share =
      advance.total == 0 ? 1.0 : static_cast<double>(advance.done) / static_cast<double>(advance.total);
  std::string text = advance.what;
  if (width > 0) {
    const auto filled = static_cast<unsigned>(std::clamp(share, 0.0, 1.0) * width);
    text += "  [" + std::string(filled, '#') + std::string(width - filled, '-') + "]";
  }
  text += "  " + std::to_string(static_cast<int>(std::clamp(share, 0.0, 1.0) * 100.0)) + " %  frame " +
          std::to_string(advance.done) + "/" + std::to_string(advance.total);
  if (advance.rate > 0.0) text += "  " + number_text(advance.rate, 3) + " frames/s";
  if (advance.seconds_left >= 0.0) text += "  " + duration_text(advance.seconds_left) + " left";
  return text;
}

pipeline::Say say_on(Log& log) {
  return [&log](pipeline::Severity severity, const std::string& message) {
    switch (severity) {
      case pipeline::Severity::detail:
        log.detail(message);
        break;
      case pipeline::Severity::info:
        log.info(message);
        break;
      case pipeline::Severity::warning:
        log.warning(message);
        break;
    }
  };
}

}  // namespace fascicle::cli
