#include "tests/cli/program.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace fascicle::tests {

TemporaryFolder::TemporaryFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "fascicle-test-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw std::system_error(errno, std::generic_category(), name);
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

Program::Program(const std::vector<std::string>& arguments, const std::vector<std::string>& environment) {
  std::vector<std::string> words{FASCICLE_PROGRAM};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  std::vector<std::string> added = environment;
  // Tests neither read nor write the user's cache.
  added.push_back("FASCICLE_CACHE_DIR=" + (folder_ / "cache"));
  std::vector<char*> envp;
  for (std::string& entry : added) envp.push_back(entry.data());
  // Of two entries of one name, getenv returns the first and a shell takes the last.
  const auto is_added = [&](std::string_view entry) {
    return std::any_of(added.begin(), added.end(), [&](const std::string& other) {
      return entry.starts_with(std::string_view(other).substr(0, other.find('=') + 1));
    });
  };
  for (char** entry = environ; *entry != nullptr; ++entry)
    if (!is_added(*entry)) envp.push_back(*entry);
  envp.push_back(nullptr);

  posix_spawn_file_actions_t files;
  ::posix_spawn_file_actions_init(&files);
  ::posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, (folder_ / "out").c_str(), O_WRONLY | O_CREAT,
                                     0600);
  ::posix_spawn_file_actions_addopen(&files, STDERR_FILENO, (folder_ / "err").c_str(), O_WRONLY | O_CREAT,
                                     0600);
  posix_spawnattr_t attributes;
  ::posix_spawnattr_init(&attributes);
  // A shell's background job ignores SIGINT, one under nohup SIGHUP, and children would inherit that.
  sigset_t defaults;
  ::sigemptyset(&defaults);
  ::sigaddset(&defaults, SIGINT);
  ::sigaddset(&defaults, SIGTERM);
  ::sigaddset(&defaults, SIGHUP);
  ::posix_spawnattr_setsigdefault(&attributes, &defaults);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
  const int error = ::posix_spawn(&process_, FASCICLE_PROGRAM, &files, &attributes, argv.data(), envp.data());
  ::posix_spawnattr_destroy(&attributes);
  ::posix_spawn_file_actions_destroy(&files);
  if (error != 0) throw std::system_error(error, std::generic_category(), FASCICLE_PROGRAM);
}

Program::~Program() {
  if (!is_running()) return;
  ::kill(process_, SIGKILL);
  wait();
}

void Program::send(int signal) const {
  if (!ended_) ::kill(process_, signal);
}

bool Program::is_running() {
  if (!ended_ && ::waitpid(process_, &raw_status_, WNOHANG) == process_) ended_ = true;
  return !ended_;
}

std::string Program::printed() const {
  return read_text(folder_ / "out");
}

Outcome Program::wait() {
  while (!ended_)
    if (::waitpid(process_, &raw_status_, 0) == process_)
      ended_ = true;
    else if (errno != EINTR)
      throw std::system_error(errno, std::generic_category(), "waitpid");
  Outcome outcome;
  if (WIFEXITED(raw_status_)) outcome.status = WEXITSTATUS(raw_status_);
  if (WIFSIGNALED(raw_status_)) outcome.signal = WTERMSIG(raw_status_);
  outcome.out = read_text(folder_ / "out");
  outcome.err = read_text(folder_ / "err");
  return outcome;
}

Outcome fascicle(const std::vector<std::string>& arguments, const std::vector<std::string>& environment) {
  return Program(arguments, environment).wait();
}

std::string read_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  if (file.peek() != std::ifstream::traits_type::eof()) text << file.rdbuf();
  return text.str();
}

void write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  if (!file.flush()) throw std::runtime_error("cannot write " + path.string());
}

std::string why_no_vulkan() {
  const nlohmann::json devices = nlohmann::json::parse(fascicle({"devices", "--json"}).out, nullptr, false);
  if (!devices.is_object()) return "fascicle devices --json printed no JSON object";
  std::string why = devices.value("why_no_vulkan", "");
  for (const nlohmann::json& device : devices["vulkan"]) {
    if (device["usable"].get<bool>()) return "";
    why = device["why_not"].get<std::string>();
  }
  return why.empty() ? "none is listed" : why;
}

bool vulkan_is_required() {
  const char* value = std::getenv("FASCICLE_REQUIRE_VULKAN");
  return value != nullptr && std::strcmp(value, "1") == 0;
}

}  // namespace fascicle::tests
