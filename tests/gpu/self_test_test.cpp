#include "gpu/self_test.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "shaders/buffers.h"
#include "tests/gpu/vulkan_device.h"
#include "tests/shaders/read_module.h"

namespace fascicle::tests {
namespace {

class SelfTest : public VulkanTest {};

TEST_F(SelfTest, TheDeviceComputesTheBitsOfThisCpu) {
  gpu::Device device(*index);
  std::string why;
  EXPECT_TRUE(device.self_test(&why)) << device.info().name << ": " << why;
  EXPECT_EQ(why, "");
}

TEST_F(SelfTest, ADifferenceIsNamed) {
  std::vector<float> results = gpu::expected_self_test();
  EXPECT_EQ(gpu::first_self_test_difference(results), "");
  results[3 * shader::self_test_results + 8] = 42.0f;
  const std::string difference = gpu::first_self_test_difference(results);
  EXPECT_EQ(difference.find("row 3, scalar operation 8:"), 0u) << difference;
}

// The control of the pass: without NoContraction, Mesa's compiler reassociates. On other drivers the shader
// may happen to give the same bits, so this requires a software device.
TEST_F(SelfTest, WithoutNoContractionTheBitsDiffer) {
  gpu::Device device(*index);
  ASSERT_TRUE(device.info().software || !vulkan_is_required()) << "this control needs a software device";
  if (!device.info().software)
    GTEST_SKIP() << "SKIPPED, CONTROL NOT RUN: " << device.info().name << " may not reorder anything";
  const std::vector<float> exact = gpu::run_self_test(device.impl(), shader::module_of("self_test"), {});
  EXPECT_EQ(gpu::first_self_test_difference(exact), "")
      << "NoContraction alone should preserve the bits here";
  const std::vector<float> loose = gpu::run_self_test(device.impl(), read_raw_module("self_test"), {});
  EXPECT_NE(gpu::first_self_test_difference(loose), "");
}

TEST(SelfTestTable, HasTheTrapsItPromises) {
  const std::vector<float> results = gpu::expected_self_test();
  ASSERT_EQ(results.size() % shader::self_test_results, 0u);
  bool fused_differs = false, reassociation_differs = false;
  for (std::size_t row = 0; row < results.size(); row += shader::self_test_results) {
    reassociation_differs |= results[row + 13] != results[row + 14];
    fused_differs |= results[row + 15] != results[row + 16];
  }
  EXPECT_TRUE(fused_differs);
  EXPECT_TRUE(reassociation_differs);
}

}  // namespace
}  // namespace fascicle::tests
