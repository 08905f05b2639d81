#include "host/build/mesher.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <csignal>
#include <stdexcept>

#include <string.h>

namespace fascicle::build {

namespace fs = std::filesystem;
using scene::SceneError;

fs::path mesher_path(const BuildOptions& options) {
  if (!options.mesher.empty()) {
    if (base::is_program(options.mesher)) return fs::absolute(options.mesher);
    throw SceneError(options.mesher.string() + ": no such program; give the path of " + mesher_name);
  }
  fs::path found = base::find_helper(mesher_name);
  if (!found.empty()) return found;
  throw SceneError(std::string(mesher_name) + ": not found in " + base::own_folder().string() +
                   " or on PATH; it fills surfaces with tetrahedra, install it beside this program");
}

ProcessLimits mesher_limits(const BuildOptions& options, double elements, double bytes_each) {
  constexpr double bytes_of_any = 256.0 * (1 << 20);
  const double due = bytes_of_any + bytes_each * elements;
  std::uint64_t bytes = options.mesher_bytes;
  if (due < static_cast<double>(bytes)) bytes = static_cast<std::uint64_t>(due);
  return {options.mesher_seconds, bytes, options.is_cancelled};
}

void fail_memory(const ProcessLimits& limits, const BuildOptions& options, std::size_t triangles,
                 const std::string& what, const std::string& cure) {
  const std::string least = what + " needs more than the " + std::to_string(limits.bytes >> 20) + " MiB ";
  if (limits.bytes == options.mesher_bytes) throw SceneError(least + "of memory allowed; " + cure);
  throw SceneError(least + "set aside for a surface of " + std::to_string(triangles) +
                   " triangles at this resolution. The cause is often thin parts, splinters or crossing "
                   "triangles. Remesh the surface, or " +
                   cure);
}

namespace {

constexpr const char* said_when_cancelled = "cancelled before the model was built";

}  // namespace

void check_cancelled(const BuildOptions& options) {
  if (options.is_cancelled && options.is_cancelled()) throw Cancelled(said_when_cancelled);
}

ProcessResult run_mesher(const fs::path& mesher, const std::vector<std::string>& arguments,
                         const ProcessLimits& limits) {
  ProcessResult result = base::run_process(mesher, arguments, limits);
  if (result.end == ProcessEnd::cancelled) throw Cancelled(said_when_cancelled);
  return result;
}

std::string digits_of(double value) {
  std::array<char, 32> digits;
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  return {digits.data(), end};
}

std::string reason(const ProcessResult& result) {
  const std::string text = base::last_line(result, mesher_name);
  return text.empty() ? "" : ": " + text;
}

void check_time(const ProcessResult& result, const ProcessLimits& limits, const std::string& what,
                const std::string& cure) {
  const std::string seconds = digits_of(limits.seconds) + " s";
  if (result.end == ProcessEnd::timed_out)
    throw SceneError(what + " took longer than the " + seconds + " of processor time allowed; " + cure);
  if (result.end == ProcessEnd::stalled)
    throw SceneError(
        what + " made no progress for " + seconds +
        ": the mesher got no processor time; find out what keeps this machine busy, and try again");
}

void check_machine(const ProcessResult& result, const std::string& what) {
  const std::string helper = mesher_name;
  if (base::was_killed_from_outside(result))
    throw std::runtime_error(helper + " was killed from outside (" + ::strsignal(result.code) + ") while " +
                             what + ", often for lack of memory; free or request more memory, and try again");
  if (result.end == ProcessEnd::exited &&
      (result.code == mesher_unreadable || result.code == mesher_cannot_write))
    throw std::runtime_error(helper + " could not " + (result.code == mesher_unreadable ? "read" : "write") +
                             " its files while " + what + reason(result) +
                             "; check the free space and permissions of the folder for temporary files "
                             "(TMPDIR), and the limit on the size of files (ulimit -f)");
}

void fail_result(const std::string& what) {
  throw SceneError(std::string(mesher_name) + " returned a mesh that cannot be used: " + what +
                   "; remesh the surface, or check that it belongs to this version of fascicle");
}

}  // namespace fascicle::build
