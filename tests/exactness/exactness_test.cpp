// The same bits everywhere: each built-in scene is stepped by programs that differ in everything that must
// not matter, and every frame's position hash is compared with the release build's on one thread.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/scene/scene.h"

namespace fascicle::tests {

namespace {

// FASCICLE_EXACTNESS_FRAMES shortens or lengthens the runs.
int frames() {
  const char* text = std::getenv("FASCICLE_EXACTNESS_FRAMES");
  return text ? std::atoi(text) : 600;
}

struct Output {
  int status = 0;
  std::string text;
};

Output run(const std::string& command) {
  Output output;
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (!pipe) return {-1, "popen failed"};
  char buffer[4096];
  while (std::size_t n = fread(buffer, 1, sizeof buffer, pipe)) output.text.append(buffer, n);
  output.status = pclose(pipe);
  return output;
}

std::string hashes(const std::string& environment, const std::string& program, const std::string& scene,
                   const std::string& device) {
  const Output output = run(environment + " " + FASCICLE_BINARY_DIR + "/" + program + " " + scene + " " +
                            std::to_string(frames()) + " " + device);
  EXPECT_EQ(output.status, 0) << program << " " << scene << " " << device << ": " << output.text;
  return output.text;
}

// The first line where two outputs differ, or nothing.
std::string first_difference(const std::string& a, const std::string& b) {
  std::istringstream lines_a(a), lines_b(b);
  std::string line_a, line_b;
  while (true) {
    const bool more_a = static_cast<bool>(std::getline(lines_a, line_a)),
               more_b = static_cast<bool>(std::getline(lines_b, line_b));
    if (!more_a && !more_b) return "";
    if (more_a != more_b) return "one of them ends early";
    if (line_a != line_b) return "frame and hash " + line_a + " against " + line_b;
  }
}

bool vulkan_is_there() {
  return run(std::string(FASCICLE_BINARY_DIR) + "/frame_hashes bar-hang-none 1 vulkan:0").status == 0;
}

class Exactness : public testing::TestWithParam<std::string> {
 protected:
  std::string reference() const { return hashes("", "frame_hashes", GetParam(), "cpu:1"); }
  void expect_same(const std::string& reference_text, const std::string& what,
                   const std::string& text) const {
    EXPECT_EQ(first_difference(reference_text, text), "") << GetParam() << ": " << what;
  }
};

TEST_P(Exactness, ThreadsOptimisationAndLibraryDoNotMatter) {
  const std::string expected = reference();
  ASSERT_EQ(std::count(expected.begin(), expected.end(), '\n'), frames());
  expect_same(expected, "2 threads", hashes("", "frame_hashes", GetParam(), "cpu:2"));
  expect_same(expected, "8 threads", hashes("", "frame_hashes", GetParam(), "cpu:8"));
  expect_same(expected, "-O0", hashes("", "frame_hashes_O0", GetParam(), "cpu:2"));
  expect_same(expected, "-O2", hashes("", "frame_hashes_O2", GetParam(), "cpu:2"));
  expect_same(expected, "-O3 -march=native", hashes("", "frame_hashes_O3_native", GetParam(), "cpu:2"));
  expect_same(expected, "C library without FMA and AVX2",
              hashes("GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-FMA", "frame_hashes", GetParam(), "cpu:2"));
}

TEST_P(Exactness, VulkanGivesTheSameBits) {
  if (!vulkan_is_there()) {
    if (std::getenv("FASCICLE_REQUIRE_VULKAN"))
      FAIL() << "FASCICLE_REQUIRE_VULKAN is set and no Vulkan device works";
    GTEST_SKIP() << "SKIPPED: no Vulkan device; bit identity with the GPU is NOT checked";
  }
  const std::string expected = reference();
  expect_same(expected, "Vulkan, 128-bit lavapipe",
              hashes("LP_NATIVE_VECTOR_WIDTH=128", "frame_hashes", GetParam(), "vulkan:0"));
  expect_same(expected, "Vulkan, 256-bit lavapipe",
              hashes("LP_NATIVE_VECTOR_WIDTH=256", "frame_hashes", GetParam(), "vulkan:0"));
}

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  for (const scene::BuiltinScene& builtin : scene::builtin_scenes()) names.push_back(builtin.name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Scenes, Exactness, testing::ValuesIn(scene_names()), [](const auto& scene) {
  std::string name = scene.param;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return name;
});

// A control: a build in which the compiler may contract a*b+c must be told apart. Without it the comparisons
// above could pass because nothing they vary has any effect.
TEST(ExactnessControl, ContractionIsSeen) {
  if (run("grep -qw fma /proc/cpuinfo").status != 0)
    GTEST_SKIP() << "SKIPPED: this CPU has no fused multiply-add, contraction cannot be planted";
  const std::string plain = hashes("", "frame_hashes", "bar-hang-along", "cpu:1");
  const std::string contracted = hashes("", "frame_hashes_contracted", "bar-hang-along", "cpu:1");
  EXPECT_NE(first_difference(plain, contracted), "");
}

// Rule 3 at its root: no fused multiply-add in the objects that hold kernel arithmetic, even where the target
// has it.
TEST(ExactnessControl, KernelObjectsHoldNoFusedMultiplyAdd) {
  const auto fused = [](const std::string& object) {
    const Output output = run("objdump -d '" + object + "' | grep -c 'vfn\\{0,1\\}m[as]'");
    return std::atoi(output.text.c_str());
  };
  const std::string native = FASCICLE_NATIVE_STAGES_OBJECT, contracted = FASCICLE_CONTRACTED_STAGES_OBJECT;
  ASSERT_TRUE(std::filesystem::exists(native)) << native;
  ASSERT_TRUE(std::filesystem::exists(contracted)) << contracted;
  EXPECT_EQ(fused(native), 0);
  const bool fma = run("grep -qw fma /proc/cpuinfo").status == 0;
  EXPECT_TRUE(!fma || fused(contracted) > 0) << "the grep finds nothing at all";
}

}  // namespace

}  // namespace fascicle::tests
