// Commands, folders and small scenes for the tests of the library, which cannot use the program's helpers.
#pragma once

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <sys/wait.h>

namespace fascicle_tests {

// A folder that is removed with its owner.
class Folder {
 public:
  Folder() : path_((std::filesystem::temp_directory_path() / "fascicle-library-XXXXXX").string()) {
    if (::mkdtemp(path_.data()) == nullptr) std::abort();
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

struct Ran {
  int status = -1;
  std::string out;  // stdout and stderr
};

inline Ran run_in_shell(const std::string& command) {
  Ran ran;
  std::FILE* pipe = ::popen(("( " + command + " ) 2>&1 < /dev/null").c_str(), "r");
  if (pipe == nullptr) return ran;
  std::array<char, 4096> bytes;
  for (std::size_t n = 0; (n = std::fread(bytes.data(), 1, bytes.size(), pipe)) > 0;)
    ran.out.append(bytes.data(), n);
  const int status = ::pclose(pipe);
  ran.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128;
  return ran;
}

// 45 vertices that hang from a wall for 6 frames.
inline constexpr const char* small_bar =
    "[scene]\nend = 0.1\n[bar]\nsize = [0.4, 0.1, 0.1]\nvertices = [5, 3, 3]\n"
    "[layers.flesh]\nalpha = 0.5\ndamping = 1.0\n"
    "[pin.wall]\nwhere = { below = { axis = \"x\", fraction = 0.0 } }\n";

}  // namespace fascicle_tests
