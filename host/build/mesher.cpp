#include "host/build/mesher.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstdlib>
#include <system_error>

#include <stdlib.h>
#include <unistd.h>

namespace fascicle::build {

namespace {

namespace fs = std::filesystem;
using scene::SceneError;

bool is_program(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored) && ::access(path.c_str(), X_OK) == 0;
}

// The last line the mesher wrote, without its name, for a message of one line.
std::string last_line(const ProcessResult& result) {
  std::string text = result.last_words;
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
  text.erase(0, text.rfind('\n') + 1);  // npos + 1 is 0
  const std::string prefix = std::string(mesher_name) + ": ";
  if (text.rfind(prefix, 0) == 0) text.erase(0, prefix.size());
  for (char& c : text) {
    if (c < ' ' || c > '~') c = '?';
  }
  constexpr std::size_t longest = 300;
  return text.substr(0, longest);
}

}  // namespace

namespace {

constexpr const char* folder_prefix = "fascicle-mesh-";

// Those of programs that were killed: no mesher runs for as long as an hour.
void remove_abandoned_folders() {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(fs::temp_directory_path(), error)) {
    if (entry.path().filename().string().rfind(folder_prefix, 0) != 0) continue;
    std::error_code ignored;
    const fs::file_time_type written = entry.last_write_time(ignored);
    if (!ignored && fs::file_time_type::clock::now() - written > std::chrono::hours(1))
      fs::remove_all(entry.path(), ignored);
  }
}

}  // namespace

TemporaryFolder::TemporaryFolder() {
  remove_abandoned_folders();
  std::string name = (fs::temp_directory_path() / (std::string(folder_prefix) + "XXXXXX")).string();
  if (::mkdtemp(name.data()) == nullptr) {
    throw std::system_error(errno, std::generic_category(), "cannot create a folder " + name);
  }
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

fs::path mesher_path(const BuildOptions& options) {
  if (!options.mesher.empty()) {
    if (is_program(options.mesher)) return fs::absolute(options.mesher);
    throw SceneError(options.mesher.string() + ": no such program; give the path of " + mesher_name);
  }
  std::error_code error;
  const fs::path own_folder = fs::read_symlink("/proc/self/exe", error).parent_path();
  if (!error && is_program(own_folder / mesher_name)) return own_folder / mesher_name;
  const char* search_path = std::getenv("PATH");
  const std::string folders = search_path == nullptr ? "" : search_path;
  for (std::size_t start = 0; start < folders.size();) {
    const std::size_t end = std::min(folders.find(':', start), folders.size());
    const fs::path candidate = fs::path(folders.substr(start, end - start)) / mesher_name;
    if (end > start && is_program(candidate)) return fs::absolute(candidate);
    start = end + 1;
  }
  throw SceneError(
      std::string(mesher_name) + ": not found in " + own_folder.string() +
      " nor on PATH; a surface needs it to be filled with tetrahedra, install it beside this program");
}

ProcessLimits mesher_limits(const BuildOptions& options) {
  return {options.mesher_seconds, options.mesher_bytes};
}

std::string digits_of(double value) {
  std::array<char, 32> digits;
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  return {digits.data(), end};
}

std::string reason(const ProcessResult& result) {
  const std::string text = last_line(result);
  return text.empty() ? "" : ": " + text;
}

void check_time(const ProcessResult& result, const ProcessLimits& limits, const std::string& what,
                const std::string& cure) {
  const std::string seconds = digits_of(limits.seconds) + " s";
  if (result.end == ProcessEnd::timed_out)
    throw SceneError(what + " took longer than the " + seconds + " of processor time allowed; " + cure);
  if (result.end == ProcessEnd::stalled)
    throw SceneError(what + " stood still for " + seconds +
                     ": the mesher got no processor time; see what holds up this machine, and try again");
}

void fail_result(const std::string& what) {
  throw SceneError(std::string(mesher_name) + " gave back a mesh that cannot be used: " + what +
                   "; remesh the surface, or check that it belongs to this version of fascicle");
}

}  // namespace fascicle::build
