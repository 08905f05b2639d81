#include "host/base/helper_program.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <stdexcept>

#include <dlfcn.h>
#include <link.h>
#include <stdlib.h>
#include <unistd.h>

#include "host/base/errors.h"

namespace fascicle::base {
namespace {

namespace fs = std::filesystem;

constexpr const char* folder_prefix = "fascicle-helper-";

// Folders of programs that were killed: no helper runs for as long as an hour.
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

void fail_to_run(const std::string& name, const std::system_error& error) {
  const std::string what = "cannot run " + name + ": " + error.what();
  if (error.code() == std::errc::executable_format_error) throw SceneError(what);
  throw std::runtime_error(
      what + "; check the free space and permissions of the folder for temporary files (TMPDIR)");
}

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

bool is_program(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored) && ::access(path.c_str(), X_OK) == 0;
}

fs::path own_module() {
  Dl_info info{};
  link_map* module = nullptr;
  // The executable's own entry in the list of loaded modules has an empty name.
  if (::dladdr1(reinterpret_cast<const void*>(&own_module), &info, reinterpret_cast<void**>(&module),
                RTLD_DL_LINKMAP) != 0 &&
      module != nullptr && module->l_name != nullptr && module->l_name[0] != '\0') {
    // With a run path, the name is "MODULE/../../lib/...", so its parents are not a textual prefix.
    const fs::path named = fs::absolute(module->l_name);
    std::error_code missing;
    const fs::path folder = fs::canonical(named.parent_path(), missing);
    return missing ? named : folder / named.filename();
  }
  std::error_code error;
  const fs::path own = fs::read_symlink("/proc/self/exe", error);
  return error ? fs::path() : own;
}

fs::path own_folder() {
  return own_module().parent_path();
}

fs::path find_helper(const std::string& name) {
  if (const fs::path own = own_folder(); !own.empty())
    for (const fs::path& folder : {own, own.parent_path() / "bin", own.parent_path().parent_path() / "bin"})
      if (is_program(folder / name)) return folder / name;
  const char* search_path = std::getenv("PATH");
  const std::string folders = search_path == nullptr ? "" : search_path;
  for (std::size_t start = 0; start < folders.size();) {
    const std::size_t end = std::min(folders.find(':', start), folders.size());
    const fs::path candidate = fs::path(folders.substr(start, end - start)) / name;
    if (end > start && is_program(candidate)) return fs::absolute(candidate);
    start = end + 1;
  }
  return {};
}

std::string last_line(const ProcessResult& result, const std::string& name) {
  std::string text = result.last_words;
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
  text.erase(0, text.rfind('\n') + 1);  // npos + 1 is 0
  const std::string prefix = name + ": ";
  if (text.rfind(prefix, 0) == 0) text.erase(0, prefix.size());
  for (char& c : text) {
    if (c < ' ' || c > '~') c = '?';
  }
  constexpr std::size_t longest = 300;
  return text.substr(0, longest);
}

}  // namespace fascicle::base
