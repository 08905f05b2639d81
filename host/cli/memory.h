// How much memory there is, and how much a process has.
#pragma once

#include <cstdint>
#include <optional>

#include <sys/types.h>

namespace fascicle::cli {

// Bytes that new processes may take, of the machine and of the control group that this one is in; nothing
// where the system does not say.
std::optional<std::uint64_t> available_memory();

// Bytes that the process holds; 0 where the system does not say.
std::uint64_t memory_of(pid_t process);

// The most bytes that this process has held so far; 0 where the system does not say.
std::uint64_t peak_memory();

}  // namespace fascicle::cli
