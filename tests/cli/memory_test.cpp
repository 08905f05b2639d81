// The memory left by a control group and its ancestors.
#include "host/cli/memory.h"

#include <filesystem>

#include <gtest/gtest.h>

#include "tests/cli/program.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;

void write_group(const fs::path& folder, const std::string& most, const std::string& taken) {
  fs::create_directories(folder);
  write_text(folder / "memory.max", most + "\n");
  write_text(folder / "memory.current", taken + "\n");
  write_text(folder / "memory.stat", "anon 1\ninactive_file 100\n");
}

TEST(Memory, ALimitMayStandOnAnyGroupAbove) {
  const TemporaryFolder root;
  write_group(root.path() / "job", "5000", "1100");
  write_group(root.path() / "job/step", "4500", "1100");
  write_group(root.path() / "job/step/task", "max", "1100");
  EXPECT_EQ(cli::left_in_groups("0::/job/step/task\n", root.path()),
            3500u);  // 4500 minus 1100, of which 100 are file cache
  EXPECT_EQ(cli::left_in_groups("0::/job\n", root.path()), 4000u);
  EXPECT_EQ(cli::left_in_groups("0::/\n", root.path()), std::nullopt);
  EXPECT_EQ(cli::left_in_groups("", root.path()), std::nullopt);
}

TEST(Memory, OldGroupsAreReadToo) {
  const TemporaryFolder root;
  const fs::path folder = root.path() / "memory/job/step";
  fs::create_directories(folder);
  write_text(folder / "memory.limit_in_bytes", "2000\n");
  write_text(folder / "memory.usage_in_bytes", "600\n");
  write_text(folder / "memory.stat", "total_inactive_file 200\n");
  EXPECT_EQ(cli::left_in_groups("5:cpu:/job\n4:memory:/job/step\n", root.path()), 1600u);
}

}  // namespace
}  // namespace fascicle::tests
