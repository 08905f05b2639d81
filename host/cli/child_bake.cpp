#include "host/cli/child_bake.h"

#include <array>
#include <cerrno>
#include <csignal>

#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include "host/base/json_text.h"
#include "host/base/process.h"
#include "host/cli/exit_codes.h"

namespace fascicle::cli {

std::optional<LogLine> read_log_line(const std::string& line) {
  const nlohmann::json said = nlohmann::json::parse(base::shallow_json(line), nullptr, false);
  if (!said.is_object()) return std::nullopt;
  const auto entry = [&](const char* key) {
    const auto found = said.find(key);
    return found != said.end() ? *found : nlohmann::json();
  };
  const nlohmann::json level = entry("level"), message = entry("message");
  if (!entry("time").is_number() || !level.is_string() || !message.is_string()) return std::nullopt;
  LogLine read{level.get<std::string>(), message.get<std::string>(), {}, {}};
  if (const nlohmann::json frame = entry("frame"); frame.is_number_unsigned()) read.frame = frame;
  if (const nlohmann::json frames = entry("frames"); frames.is_number_unsigned()) read.frames = frames;
  return read;
}

ChildBake::ChildBake(std::vector<std::string> arguments) {
  // Not the path behind the link: that file may have been replaced since this program started.
  arguments.insert(arguments.begin(), "/proc/self/exe");
  arguments.insert(arguments.end(), {"--log-format", "json"});
  auto [heard, spoken] = base::make_pipe();
  ::fcntl(heard.get(), F_SETFL, O_NONBLOCK);
  process_ = base::start_process(arguments, spoken.get());
  descriptor_ = std::move(heard);
}

ChildBake::~ChildBake() {
  if (!ended_) {
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
  }
}

void ChildBake::listen() {
  std::array<char, 4096> part{};
  while (descriptor_.get() >= 0) {
    const ssize_t count = ::read(descriptor_.get(), part.data(), part.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return;
    if (count == 0) {
      descriptor_.close();
      if (!unread_.empty()) take_line(std::exchange(unread_, {}));
      return;
    }
    unread_.append(part.data(), static_cast<std::size_t>(count));
    for (std::size_t end; (end = unread_.find('\n')) != std::string::npos;) {
      take_line(unread_.substr(0, end));
      unread_.erase(0, end + 1);
    }
  }
}

void ChildBake::take_line(const std::string& line) {
  const std::optional<LogLine> said = read_log_line(line);
  if (!said) {
    // More than anyone reads: a driver may repeat itself for hours.
    constexpr std::size_t most = 100;
    if (!line.empty() && other_count_++ < most) other_lines_.push_back(line);
    return;
  }
  if (said->level == "error") error_ = said->message;
  if (said->level == "warning") warnings_.push_back(said->message);
  if (said->level == "progress") {
    frame_ = said->frame.value_or(frame_);
    frames_ = said->frames.value_or(frames_);
  }
}

void ChildBake::interrupt() {
  interrupted_ = true;
  if (!ended_) ::kill(process_, SIGINT);
}

bool ChildBake::has_ended() {
  if (ended_) return true;
  int status = 0;
  if (::waitpid(process_, &status, WNOHANG) != process_) return false;
  ended_ = true;
  listen();
  status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  // SIGINT before the handlers are installed: the child had not started anything.
  if (interrupted_ && WIFSIGNALED(status) && WTERMSIG(status) == SIGINT)
    status_ = static_cast<int>(ExitCode::interrupted);
  return true;
}

}  // namespace fascicle::cli
