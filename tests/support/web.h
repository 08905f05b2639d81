// The browser pages and the tools that test them. npm's tools are in BUILD/web, where ./do test installs them
// from web/package-lock.json; without them, tests are skipped with a message. So are tests without Debian's
// Chromium, unless FASCICLE_REQUIRE_CHROMIUM=1: then they fail.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

#include "tests/support/readers.h"

namespace fascicle::tests {

inline std::filesystem::path web_tools() {
  return std::filesystem::path(FASCICLE_BINARY_DIR) / "web";
}

inline bool have_web_tools() {
  return std::filesystem::exists(web_tools() / "node_modules") &&
         std::system("node --version > /dev/null 2>&1") == 0;
}

inline bool have_chromium() {
  return std::system("command -v chromium > /dev/null 2>&1") == 0;
}

// Runs a command in BUILD/web with the current sources of web/. Its output goes to `log`; returns the exit
// status.
int run_web(const std::string& command, const std::filesystem::path& log);

#define FASCICLE_NEEDS_WEB_TOOLS                                          \
  if (!::fascicle::tests::have_web_tools())                               \
    GTEST_SKIP() << "SKIPPED, NOT TESTED: no tools of web/ in the build " \
                    "folder; ./do test installs them with npm";           \
  static_assert(true)
#define FASCICLE_NEEDS_CHROMIUM                                                                            \
  FASCICLE_NEEDS(::fascicle::tests::have_chromium(), "FASCICLE_REQUIRE_CHROMIUM", "chromium on the PATH"); \
  FASCICLE_NEEDS_WEB_TOOLS

}  // namespace fascicle::tests
