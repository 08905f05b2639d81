// Common to all calls of fascicle-mesher: finding it, its exit status, its last line of output.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/base/helper_program.h"
#include "host/build/build.h"

namespace fascicle::build {

// The exit status, as fascicle-mesher --help documents it.
enum MesherStatus : int {
  mesher_done = 0,
  mesher_unreadable = 3,
  mesher_not_closed = 4,
  mesher_self_intersecting = 5,
  mesher_out_of_memory = 6,
  mesher_failed = 7,
  mesher_empty_result = 8,
  mesher_cannot_write = 9,
  mesher_wrap_failed = 10,
};

inline constexpr const char* mesher_name = "fascicle-mesher";

using base::ProcessEnd;
using base::ProcessLimits;
using base::ProcessResult;
using base::TemporaryFolder;

// The mesher in the options, else the one beside this executable, else the first on PATH. Throws
// scene::SceneError.
std::filesystem::path mesher_path(const BuildOptions& options);

// The options' limits, with a lower memory limit if less should do: 0.25 GiB plus `bytes_each` for each
// element that a good surface needs at the requested resolution. Otherwise a malformed surface with a few
// splinters would take all the memory it can get.
ProcessLimits mesher_limits(const BuildOptions& options, double elements, double bytes_each);

// Reports that a run over a surface of so many triangles ran out of memory; `cure` names what needs less.
// Throws scene::SceneError.
[[noreturn]] void fail_memory(const ProcessLimits& limits, const BuildOptions& options, std::size_t triangles,
                              const std::string& what, const std::string& cure);

// Throws Cancelled if options.is_cancelled returns true.
void check_cancelled(const BuildOptions& options);

// Runs the mesher with scene::run_process. Throws Cancelled if the limits' is_cancelled returned true.
ProcessResult run_mesher(const std::filesystem::path& mesher, const std::vector<std::string>& arguments,
                         const ProcessLimits& limits);

// The shortest text that reads back as the same value.
std::string digits_of(double value);

// ": " and the last line that the mesher wrote, without its name, for a one-line message; or nothing.
std::string reason(const ProcessResult& result);

// Throws scene::SceneError if a run exceeded its processor time or stalled. `what` is what it did, `cure`
// names what needs less time.
void check_time(const ProcessResult& result, const ProcessLimits& limits, const std::string& what,
                const std::string& cure);

// Throws std::runtime_error if the machine ended a run, not the surface: the mesher was killed from outside,
// or could not read or write its files. `what` as above.
void check_machine(const ProcessResult& result, const std::string& what);

// Reports that a result cannot be used, and what to do. Throws scene::SceneError.
[[noreturn]] void fail_result(const std::string& what);

}  // namespace fascicle::build
