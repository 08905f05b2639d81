#include "host/cli/memory.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <string>

namespace fascicle::cli {
namespace {

// The number behind a name in one of the kernel's files.
std::optional<std::uint64_t> number_in(const std::string& file, const std::string& name) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);)
    if (line.starts_with(name)) return std::strtoull(line.c_str() + name.size(), nullptr, 10);
  return std::nullopt;
}

// The only number in a file; nothing where there is another word, such as "max".
std::optional<std::uint64_t> only_number_in(const std::string& file) {
  std::uint64_t number = 0;
  std::ifstream in(file);
  return in >> number ? std::optional(number) : std::nullopt;
}

// What the control group may still take; what it holds of files can be given back.
std::optional<std::uint64_t> left_in_group() {
  std::ifstream in("/proc/self/cgroup");
  std::string line, folder;
  while (std::getline(in, line))
    if (line.starts_with("0::")) folder = "/sys/fs/cgroup" + line.substr(3);
  if (folder.empty()) return std::nullopt;
  const std::optional<std::uint64_t> most = only_number_in(folder + "/memory.max");
  const std::optional<std::uint64_t> taken = only_number_in(folder + "/memory.current");
  if (!most || !taken) return std::nullopt;
  const std::uint64_t files = number_in(folder + "/memory.stat", "inactive_file ").value_or(0);
  const std::uint64_t held = *taken - std::min(*taken, files);
  return *most - std::min(*most, held);
}

}  // namespace

std::optional<std::uint64_t> available_memory() {
  std::optional<std::uint64_t> available = number_in("/proc/meminfo", "MemAvailable:");
  if (available) *available *= 1024;
  const std::optional<std::uint64_t> of_group = left_in_group();
  if (of_group && (!available || *of_group < *available)) available = of_group;
  return available;
}

std::uint64_t memory_of(pid_t process) {
  return 1024 * number_in("/proc/" + std::to_string(process) + "/status", "VmRSS:").value_or(0);
}

std::uint64_t peak_memory() {
  return 1024 * number_in("/proc/self/status", "VmHWM:").value_or(0);
}

}  // namespace fascicle::cli
