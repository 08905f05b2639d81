// Available memory, and the memory use of processes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <sys/types.h>

namespace fascicle::cli {

// Bytes that new processes may allocate, given the machine and this process's control group; nullopt if
// unknown.
std::optional<std::uint64_t> available_memory();

// The smallest amount still available in the control groups that `groups` (the text of /proc/self/cgroup)
// lists and in all their ancestors, of either version; `root` is their mount point. nullopt if none has a
// limit.
std::optional<std::uint64_t> left_in_groups(const std::string& groups, const std::string& root);

// Return freed arrays to the system at once. Otherwise, memory freed by the build would be a tenth of the
// peak of a body of 100,000 vertices. Only affects glibc.
void give_freed_arrays_back();
// Keep freed arrays in the process, for a loop that allocates and frees the same ones repeatedly: new pages
// cost more than writing to them. Applies to arrays up to 16 MiB, and 64 MiB at the end of each thread's
// heap.
void keep_freed_arrays();

// Bytes resident in the process; 0 if unknown.
std::uint64_t memory_of(pid_t process);

// Peak of this process so far, in bytes; 0 if unknown.
std::uint64_t peak_memory();

}  // namespace fascicle::cli
