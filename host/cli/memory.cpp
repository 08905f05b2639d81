#include "host/cli/memory.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace fascicle::cli {
namespace {

// Arrays of at least `mapped_bytes` get their own mappings; up to `kept_bytes` at the end of the heap are
// kept when free.
void set_limits_of_heap([[maybe_unused]] int mapped_bytes, [[maybe_unused]] int kept_bytes) {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, mapped_bytes);
  mallopt(M_TRIM_THRESHOLD, kept_bytes);
#endif
}

// The number after a name in one of the kernel's files.
std::optional<std::uint64_t> number_in(const std::string& file, const std::string& name) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);)
    if (line.starts_with(name)) return std::strtoull(line.c_str() + name.size(), nullptr, 10);
  return std::nullopt;
}

// The only number in a file; nullopt for a word such as "max".
std::optional<std::uint64_t> only_number_in(const std::string& file) {
  std::uint64_t number = 0;
  std::ifstream in(file);
  return in >> number ? std::optional(number) : std::nullopt;
}

// What a group may still allocate. Cached files do not count, since they can be reclaimed.
std::optional<std::uint64_t> left_in(const std::string& folder, const char* most_name, const char* taken_name,
                                     const char* files_name) {
  const std::optional<std::uint64_t> most = only_number_in(folder + most_name);
  const std::optional<std::uint64_t> taken = only_number_in(folder + taken_name);
  if (!most || !taken) return std::nullopt;
  const std::uint64_t files = number_in(folder + "/memory.stat", files_name).value_or(0);
  const std::uint64_t held = *taken - std::min(*taken, files);
  return *most - std::min(*most, held);
}

}  // namespace

std::optional<std::uint64_t> left_in_groups(const std::string& groups, const std::string& root) {
  std::optional<std::uint64_t> least;
  std::istringstream lines(groups);
  for (std::string line; std::getline(lines, line);) {
    const bool is_old = line.find(":memory:") != std::string::npos;
    if (!line.starts_with("0::") && !is_old) continue;
    // Any ancestor may set a limit: a job's group, for example, instead of its task's.
    for (std::string group = line.substr(line.rfind(':') + 1); !group.empty();
         group.erase(std::min(group.rfind('/'), group.size()))) {
      const std::optional<std::uint64_t> left =
          is_old ? left_in(root + "/memory" + group, "/memory.limit_in_bytes", "/memory.usage_in_bytes",
                           "total_inactive_file ")
                 : left_in(root + group, "/memory.max", "/memory.current", "inactive_file ");
      if (left && (!least || *left < *least)) least = left;
    }
  }
  return least;
}

void give_freed_arrays_back() {
  set_limits_of_heap(128 << 10, 128 << 10);
}

void keep_freed_arrays() {
  set_limits_of_heap(16 << 20, 64 << 20);
}

std::optional<std::uint64_t> available_memory() {
  std::optional<std::uint64_t> available = number_in("/proc/meminfo", "MemAvailable:");
  if (available) *available *= 1024;
  std::ifstream in("/proc/self/cgroup");
  const std::string groups{std::istreambuf_iterator<char>(in), {}};
  const std::optional<std::uint64_t> of_group = left_in_groups(groups, "/sys/fs/cgroup");
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
