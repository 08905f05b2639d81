#include "host/base/pending_output.h"

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

namespace fascicle::base {
namespace {

namespace fs = std::filesystem;

constexpr const char* part_suffix = ".part-";

// The signals that end a process, except SIGKILL.
constexpr std::array ending{SIGHUP, SIGINT,  SIGQUIT, SIGTERM, SIGXCPU,
                            SIGILL, SIGABRT, SIGBUS,  SIGFPE,  SIGSEGV};

// A signal handler receives no context, so its data must be global.
struct Listener {
  const char* part = nullptr;
  std::array<struct sigaction, ending.size()> before{};
};
Listener& listener() {
  static Listener listener;
  return listener;
}

// SA_RESETHAND restores the default action: raising the same signal again ends the process with that signal
// as its status.
void remove_part(int number) {
  if (listener().part != nullptr) ::unlink(listener().part);
  ::raise(number);
}

[[noreturn]] void fail(const std::string& path) {
  throw std::system_error(errno, std::generic_category(), path);
}

// From helpers that were killed: no helper runs for as long as an hour.
void remove_abandoned_parts(const fs::path& path) {
  const std::string prefix = path.filename().string() + part_suffix;
  std::error_code error;
  for (const fs::directory_entry& entry :
       fs::directory_iterator(path.has_parent_path() ? path.parent_path() : fs::path("."), error)) {
    const std::string name = entry.path().filename().string();
    if (name.rfind(prefix, 0) != 0 || name.size() == prefix.size() ||
        name.find_first_not_of("0123456789", prefix.size()) != std::string::npos)
      continue;
    std::error_code ignored;
    const fs::file_time_type written = entry.last_write_time(ignored);
    if (!ignored && fs::file_time_type::clock::now() - written > std::chrono::hours(1))
      fs::remove(entry.path(), ignored);
  }
}

}  // namespace

PendingOutput::PendingOutput(const std::string& path)
    : path_(path), part_(path + part_suffix + std::to_string(::getpid())) {
  remove_abandoned_parts(path_);
  // An existing name may be a link to anywhere, which must not be written through.
  ::unlink(part_.c_str());
  file_ = Descriptor(::open(part_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666));
  if (file_.get() < 0) fail(path_);
  listen();
}

PendingOutput::~PendingOutput() {
  listen_no_more();
  if (!is_whole_) ::unlink(part_.c_str());
}

void PendingOutput::finish(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file_.get(), bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(path_);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  if (::fsync(file_.get()) != 0 || ::rename(part_.c_str(), path_.c_str()) != 0) fail(path_);
  is_whole_ = true;
}

void PendingOutput::listen() {
  if (listener().part != nullptr) return;
  constexpr std::size_t stack_size = 65536;
  stack_.resize(stack_size);
  const stack_t stack{stack_.data(), 0, stack_.size()};
  ::sigaltstack(&stack, nullptr);
  listener().part = part_.c_str();
  listens_ = true;
  struct sigaction action {};
  action.sa_handler = remove_part;
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_NODEFER | SA_ONSTACK);
  for (std::size_t k = 0; k < ending.size(); ++k) {
    ::sigaction(ending[k], &action, &listener().before[k]);
    // Keeps ignored signals ignored, as with nohup.
    if (listener().before[k].sa_handler == SIG_IGN) ::sigaction(ending[k], &listener().before[k], nullptr);
  }
}

void PendingOutput::listen_no_more() {
  if (!listens_) return;
  for (std::size_t k = 0; k < ending.size(); ++k) ::sigaction(ending[k], &listener().before[k], nullptr);
  listener().part = nullptr;
  const stack_t none{nullptr, SS_DISABLE, 0};
  ::sigaltstack(&none, nullptr);
}

}  // namespace fascicle::base
