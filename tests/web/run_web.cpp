#include <filesystem>
#include <string>

#include <sys/wait.h>

#include "tests/support/web.h"

namespace fascicle::tests {

namespace fs = std::filesystem;

int run_web(const std::string& command, const fs::path& log) {
  const fs::path from = fs::path(FASCICLE_SOURCE_DIR) / "web", to = web_tools();
  for (const char* folder : {"src", "tests"})
    fs::copy(from / folder, to / folder, fs::copy_options::recursive | fs::copy_options::overwrite_existing);
  for (const char* file : {"build.mjs", "test.mjs", "tsconfig.json"})
    fs::copy_file(from / file, to / file, fs::copy_options::overwrite_existing);
  const std::string line = "cd '" + to.string() + "' && " + command + " > '" + log.string() + "' 2>&1";
  const int status = std::system(line.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace fascicle::tests
