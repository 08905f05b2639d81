// What all calls of fascicle-mesher have in common: finding it, its exit status, its last words.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/base/helper_program.h"
#include "host/build/build.h"

namespace fascicle::build {

// What fascicle-mesher --help says of its exit status.
enum MesherStatus : int {
  mesher_done = 0,
  mesher_not_closed = 4,
  mesher_self_intersecting = 5,
  mesher_out_of_memory = 6,
  mesher_failed = 7,
  mesher_empty_result = 8,
  mesher_wrap_failed = 10,
};

inline constexpr const char* mesher_name = "fascicle-mesher";

using base::ProcessEnd;
using base::ProcessLimits;
using base::ProcessResult;
using base::TemporaryFolder;

// The options' mesher, or the one beside this executable, or the first on PATH. Throws scene::SceneError.
std::filesystem::path mesher_path(const BuildOptions& options);

// The options' limits; of memory less where less is due: a quarter of a GiB and `bytes_each` for each of the
// elements that a good surface needs at the resolution asked for. A stranger's surface of a few splinters
// takes as much as it gets.
ProcessLimits mesher_limits(const BuildOptions& options, double elements, double bytes_each);

// Says that a run over a surface of so many triangles had no more memory; `cure` is what needs less. Throws
// scene::SceneError.
[[noreturn]] void fail_memory(const ProcessLimits& limits, const BuildOptions& options, std::size_t triangles,
                              const std::string& what, const std::string& cure);

// Throws Cancelled where options.is_cancelled says so.
void check_cancelled(const BuildOptions& options);

// scene::run_process of the mesher. Throws Cancelled where the limits' is_cancelled said so.
ProcessResult run_mesher(const std::filesystem::path& mesher, const std::vector<std::string>& arguments,
                         const ProcessLimits& limits);

// The shortest text that reads back the same.
std::string digits_of(double value);

// ": " and the last line the mesher wrote, without its name, for a message of one line; or nothing.
std::string reason(const ProcessResult& result);

// Throws scene::SceneError where a run ran out of processor time or stood still. `what` is what it did,
// `cure` what needs less time.
void check_time(const ProcessResult& result, const ProcessLimits& limits, const std::string& what,
                const std::string& cure);

// Says that a result cannot be used, and what to do. Throws scene::SceneError.
[[noreturn]] void fail_result(const std::string& what);

}  // namespace fascicle::build
