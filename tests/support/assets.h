// Real meshes and characters for tests. They are not part of the repository: without them, tests are skipped
// with a message, or fail if FASCICLE_REQUIRE_ASSETS=1.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

namespace fascicle::tests {

inline std::filesystem::path asset(const std::string& name) {
  return std::filesystem::path(FASCICLE_SOURCE_DIR) / ".." / "shared" / "assets" / name;
}

inline bool assets_are_required() {
  const char* value = std::getenv("FASCICLE_REQUIRE_ASSETS");
  return value != nullptr && std::string(value) == "1";
}

// Ends the test, or its SetUp, if the file is missing.
#define FASCICLE_NEEDS_ASSET(path)                                                          \
  if (!std::filesystem::exists(path)) {                                                     \
    if (::fascicle::tests::assets_are_required())                                           \
      FAIL() << "FASCICLE_REQUIRE_ASSETS=1, but this file is missing: " << (path).string(); \
    GTEST_SKIP() << "SKIPPED, NOT TESTED: missing " << (path).string();                     \
  }                                                                                         \
  static_assert(true)

}  // namespace fascicle::tests
