// Third-party programs that read back our output. Those for Node.js are in BUILD/readers, where ./do test
// installs them from tests/readers/package-lock.json. Without them, tests are skipped with a message, or fail
// if FASCICLE_REQUIRE_READERS=1 (Node.js) or FASCICLE_REQUIRE_BLENDER=1.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

namespace fascicle::tests {

inline bool is_required(const char* variable) {
  const char* value = std::getenv(variable);
  return value != nullptr && std::string(value) == "1";
}

inline std::filesystem::path node_readers() {
  return std::filesystem::path(FASCICLE_BINARY_DIR) / "readers";
}

inline bool have_node_readers() {
  return std::filesystem::exists(node_readers() / "node_modules") &&
         std::system("node --version > /dev/null 2>&1") == 0;
}

// What a script for Node.js, of tests/readers, prints about a file.
inline std::string read_by_node(const std::string& script, const std::filesystem::path& file) {
  const std::string command = "node '" + (node_readers() / script).string() + "' '" + file.string() + "'";
  FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return "";
  std::string text;
  char block[4096];
  for (std::size_t count = 0; (count = std::fread(block, 1, sizeof block, pipe)) > 0;)
    text.append(block, count);
  EXPECT_EQ(::pclose(pipe), 0) << command;
  return text;
}

inline bool have_blender() {
  return std::system("command -v blender > /dev/null 2>&1") == 0;
}

// Ends the test if the programs are missing.
#define FASCICLE_NEEDS(have, variable, what)                                             \
  if (!(have)) {                                                                         \
    if (::fascicle::tests::is_required(variable)) FAIL() << variable "=1, and no " what; \
    GTEST_SKIP() << "SKIPPED, NOT TESTED: no " what;                                     \
  }                                                                                      \
  static_assert(true)
#define FASCICLE_NEEDS_NODE_READERS                                                  \
  FASCICLE_NEEDS(::fascicle::tests::have_node_readers(), "FASCICLE_REQUIRE_READERS", \
                 "readers in the build folder; ./do test installs them with npm")
#define FASCICLE_NEEDS_BLENDER \
  FASCICLE_NEEDS(::fascicle::tests::have_blender(), "FASCICLE_REQUIRE_BLENDER", "blender on the PATH")

}  // namespace fascicle::tests
