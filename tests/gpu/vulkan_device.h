// A Vulkan device for tests. Without one, tests are skipped with a message; with FASCICLE_REQUIRE_VULKAN=1,
// as in CI, they fail.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "gpu/device.h"

namespace fascicle::tests {

inline std::optional<std::uint32_t> usable_device(std::string& why) {
  for (const gpu::DeviceInfo& info : gpu::list_devices(&why)) {
    if (info.usable) return info.index;
    why = info.name + ": " + info.why_not;
  }
  return std::nullopt;
}

inline bool vulkan_is_required() {
  const char* value = std::getenv("FASCICLE_REQUIRE_VULKAN");
  return value != nullptr && std::string(value) == "1";
}

class VulkanTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string why;
    index = usable_device(why);
    if (index) return;
    if (vulkan_is_required()) FAIL() << "FASCICLE_REQUIRE_VULKAN=1 but no usable device: " << why;
    GTEST_SKIP() << "NO VULKAN DEVICE, nothing was tested: " << why;
  }
  std::optional<std::uint32_t> index;
};

}  // namespace fascicle::tests
