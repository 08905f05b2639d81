// Helper programs, which do what may crash: finding them, their last words, a folder for their files.
#pragma once

#include <filesystem>
#include <string>
#include <system_error>

#include "host/base/process.h"

namespace fascicle::base {

// A temporary folder, removed by the destructor.
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
// The file that contains this code: the executable, or the shared library that another program has loaded.
// Empty if the system does not say.
std::filesystem::path own_module();
// Its folder; may be empty.
std::filesystem::path own_folder();
// Looks for the program beside that file, then in the folder `bin` beside the file's folder or one level up
// (where an installed library finds it), then on PATH. Empty if there is none.
std::filesystem::path find_helper(const std::string& name);

// For a helper that could not be started, or whose temporary files could not be written: throws
// std::runtime_error, because the machine is to blame and not the input, or SceneError if the file given as
// the helper is no program.
[[noreturn]] void fail_to_run(const std::string& name, const std::system_error& error);

// The last line that the helper wrote, without the helper's name, for a one-line message; may be empty.
std::string last_line(const ProcessResult& result, const std::string& name);

}  // namespace fascicle::base
