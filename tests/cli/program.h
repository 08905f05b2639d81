// Runs the built executable as a user would.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include <sys/types.h>

namespace fascicle::tests {

// A temporary folder that is removed by its owner's destructor.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

struct Outcome {
  int status = -1;  // exit status
  int signal = 0;   // the signal that ended it, or 0
  std::string out, err;
};

// A running `fascicle ARGUMENTS...`, with default signal handling; stdout and stderr go to files.
class Program {
 public:
  explicit Program(const std::vector<std::string>& arguments,
                   const std::vector<std::string>& environment = {});
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  void send(int signal) const;
  bool is_running();
  // What it has printed so far.
  std::string printed() const;
  Outcome wait();

 private:
  TemporaryFolder folder_;
  pid_t process_ = -1;
  bool ended_ = false;
  int raw_status_ = 0;
};

// Waits until `condition` holds or the program has ended, and returns whether it holds. Sleeps between
// checks.
template <class Condition>
bool wait_until(Program& program, Condition condition) {
  while (!condition()) {
    if (!program.is_running()) return condition();
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

inline bool wait_for_file(Program& program, const std::filesystem::path& file) {
  return wait_until(program, [&] { return std::filesystem::exists(file); });
}

// Runs the program to its end. `environment` adds NAME=VALUE entries.
Outcome fascicle(const std::vector<std::string>& arguments, const std::vector<std::string>& environment = {});

std::string read_text(const std::filesystem::path& path);
void write_text(const std::filesystem::path& path, const std::string& text);

}  // namespace fascicle::tests

// Skips the test if there is no Vulkan device; with FASCICLE_REQUIRE_VULKAN=1 it fails instead.
#define NEEDS_VULKAN()                                                                 \
  do {                                                                                 \
    const std::string without = fascicle::tests::why_no_vulkan();                      \
    if (!without.empty() && fascicle::tests::vulkan_is_required())                     \
      FAIL() << "no Vulkan device: " << without;                                       \
    if (!without.empty()) GTEST_SKIP() << "NO VULKAN DEVICE, NOT TESTED: " << without; \
  } while (false)

namespace fascicle::tests {

// Empty if `fascicle devices` finds a usable Vulkan device.
std::string why_no_vulkan();
bool vulkan_is_required();

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace fascicle::tests
