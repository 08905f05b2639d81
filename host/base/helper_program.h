// Programs of our own that do what may crash: finding them, their last words, a folder for their files.
#pragma once

#include <filesystem>
#include <string>

#include "host/base/process.h"

namespace fascicle::base {

// A folder of our own that goes when this does.
class TemporaryFolder {
 public:
  TemporaryFolder();  // throws std::system_error
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder();
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

bool is_program(const std::filesystem::path& path);
// The file that holds this code: the executable, or the shared library that another program has loaded; empty
// where the system does not say.
std::filesystem::path own_module();
// Its folder, or empty.
std::filesystem::path own_folder();
// The program of this name beside that file, in the folder `bin` beside its folder or one above (where a
// library is installed), or the first on PATH; empty where there is none.
std::filesystem::path find_helper(const std::string& name);

// The last line that the helper wrote, without its name, for a message of one line; or nothing.
std::string last_line(const ProcessResult& result, const std::string& name);

}  // namespace fascicle::base
