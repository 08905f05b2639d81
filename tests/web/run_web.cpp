#include <filesystem>
#include <string>

#include <sys/wait.h>
#include <unistd.h>

#include "tests/cli/program.h"
#include "tests/support/web.h"

namespace fascicle::tests {

namespace fs = std::filesystem;

namespace {

// Tests run beside each other, so a copy that another one reads must never be half a file.
void update(const fs::path& from, const fs::path& to) {
  if (fs::exists(to) && read_text(from) == read_text(to)) return;
  const fs::path partial = to.string() + ".partial" + std::to_string(getpid());
  fs::create_directories(to.parent_path());
  fs::copy_file(from, partial);
  fs::rename(partial, to);
}

}  // namespace

int run_web(const std::string& command, const fs::path& log) {
  const fs::path from = fs::path(FASCICLE_SOURCE_DIR) / "web", to = web_tools();
  for (const char* folder : {"src", "tests"})
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(from / folder))
      if (entry.is_regular_file()) update(entry.path(), to / fs::relative(entry.path(), from));
  for (const char* file : {"build.mjs", "test.mjs", "tsconfig.json"}) update(from / file, to / file);
  const std::string line = "cd '" + to.string() + "' && " + command + " > '" + log.string() + "' 2>&1";
  const int status = std::system(line.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace fascicle::tests
