// How much memory there is, and how much a process has.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <sys/types.h>

namespace fascicle::cli {

// Bytes that new processes may take, of the machine and of the control group that this one is in; nothing
// where the system does not say.
std::optional<std::uint64_t> available_memory();

// The least that may still be taken in the control groups that /proc/self/cgroup lists as `groups` and in all
// above them, of either version; `root` is where they are mounted. Nothing where none has a limit.
std::optional<std::uint64_t> left_in_groups(const std::string& groups, const std::string& root);

// Freed arrays go back to the system at once: what building leaves behind would be a tenth of the peak of a
// body of 100,000 vertices. For glibc; elsewhere nothing changes.
void give_freed_arrays_back();
// They stay with the process, for a loop that frees and takes the same ones over and over: new pages cost
// more than what is written to them. Of arrays of up to 16 MiB, and 64 MiB of them in all.
void keep_freed_arrays();

// Bytes that the process holds; 0 where the system does not say.
std::uint64_t memory_of(pid_t process);

// The most bytes that this process has held so far; 0 where the system does not say.
std::uint64_t peak_memory();

}  // namespace fascicle::cli
