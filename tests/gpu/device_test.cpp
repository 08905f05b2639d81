#include "gpu/device.h"

#include <algorithm>
#include <array>

#include <gtest/gtest.h>

#include "gpu/check.h"
#include "gpu/physical_device.h"
#include "shaders/modules.h"
#include "shaders/spirv_exact/exact.h"
#include "tests/gpu/vulkan_device.h"

namespace fascicle::tests {
namespace {

TEST(DeviceList, IsEmptyWithAReasonOrNumbered) {
  std::string why;
  const std::vector<gpu::DeviceInfo> devices = gpu::list_devices(&why);
  EXPECT_EQ(devices.empty(), !why.empty());
  for (std::size_t k = 0; k < devices.size(); ++k) {
    EXPECT_EQ(devices[k].index, k);
    EXPECT_FALSE(devices[k].name.empty());
    EXPECT_EQ(devices[k].usable, devices[k].why_not.empty());
    EXPECT_EQ(devices[k].software, devices[k].type == "cpu");
  }
}

TEST(Check, ThrowsTheCallsText) {
  EXPECT_NO_THROW(gpu::check(VK_SUCCESS, "vkSomething()"));
  EXPECT_NO_THROW(gpu::check(VK_NOT_READY, "vkSomething()"));
  EXPECT_NO_THROW(gpu::check(VK_INCOMPLETE, "vkSomething()"));
  EXPECT_THROW(gpu::check(VK_TIMEOUT, "vkSomething()"), gpu::DeviceError);
  try {
    gpu::check(VK_ERROR_DEVICE_LOST, "device.call.vkSomething(queue)");
    FAIL();
  } catch (const gpu::DeviceError& error) {
    EXPECT_STREQ(error.what(), "vkSomething: VK_ERROR_DEVICE_LOST");
  }
}

// A device that binds fewer buffers than the largest kernel uses is refused, so the limit must be that
// kernel's number.
TEST(PhysicalDevice, MostBuffersOfAKernelIsTheLargestKernels) {
  std::size_t most = 0;
  for (const std::string_view name : shader::module_names())
    most = std::max(most, spirv_exact::used_bindings(shader::module_of(name)).size());
  EXPECT_EQ(most, gpu::most_buffers_of_a_kernel);
}

class OpenDevice : public VulkanTest {};

// Whatever cache it is given, the device computes the same: it uses its own data and ignores other data.
TEST_F(OpenDevice, TakesPipelinesOfAnEarlierRunAndLeavesOthersAlone) {
  gpu::Device first(*index);
  ASSERT_TRUE(first.self_test());
  const std::string own = first.pipelines();
  ASSERT_GE(own.size(), 32u) << "shorter than a header";
  EXPECT_EQ(first.info().pipelines_key.size(), 48u);
  std::string of_another_driver = own;
  of_another_driver[20] = static_cast<char>(of_another_driver[20] + 1);  // in the driver's UUID
  for (const std::string& pipelines : {own, of_another_driver, own.substr(0, 9), std::string(500, 'x')}) {
    gpu::Device device(*index, {.pipelines = pipelines});
    EXPECT_TRUE(device.self_test());
  }
}

TEST(PhysicalDevice, PipelinesAreKeptByDeviceAndDriver) {
  std::array<std::uint8_t, VK_UUID_SIZE> driver{};
  const std::string key = gpu::pipelines_key(0x10de, 1, driver);
  EXPECT_EQ(key, "000010de00000001" + std::string(32, '0'));
  EXPECT_NE(gpu::pipelines_key(0x10de, 2, driver), key);
  driver[15] = 1;
  EXPECT_NE(gpu::pipelines_key(0x10de, 1, driver), key);
}

TEST_F(OpenDevice, ThatDoesNotExistIsRefusedWithTheCount) {
  try {
    gpu::Device device(1000);
    FAIL();
  } catch (const gpu::DeviceError& error) {
    EXPECT_NE(std::string(error.what()).find("no Vulkan device 1000"), std::string::npos) << error.what();
  }
}

TEST_F(OpenDevice, TwoCanBeOpenAtOnce) {
  gpu::Device first(*index), second(*index);
  EXPECT_TRUE(first.self_test());
  EXPECT_TRUE(second.self_test());
}

}  // namespace
}  // namespace fascicle::tests
