// A device for a test that the Khronos validation layer looks at. Without the layer the test is skipped,
// loudly.
#pragma once

#include <string>

#include "tests/gpu/vulkan_device.h"
#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/lsan_interface.h>
#endif

namespace fascicle::tests {

class ValidatedTest : public VulkanTest {
#if defined(__SANITIZE_ADDRESS__)
  // The layer keeps memory when it is unloaded.
  const __lsan::ScopedDisabler layer_leaks_{};
#endif

 protected:
  void SetUp() override {
#if defined(__SANITIZE_THREAD__)
    // The layer is compiled without the sanitizer, which then does not see how its threads wait for each
    // other, and reports that one frees what another has just unlocked.
    GTEST_SKIP() << "SKIPPED: the layer's own threads are reported by the thread sanitizer";
#endif
    VulkanTest::SetUp();
    if (!index) return;
    try {
      gpu::DeviceOptions options;
      options.validation = true;
      const gpu::Device device(*index, options);
    } catch (const gpu::DeviceError& error) {
      if (vulkan_is_required()) FAIL() << error.what();
      GTEST_SKIP() << "NOTHING WAS VALIDATED: " << error.what();
    }
  }
};

}  // namespace fascicle::tests
