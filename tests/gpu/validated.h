// A device for tests with the Khronos validation layer. Without the layer, tests are skipped with a message.
#pragma once

#include <string>

#include "tests/gpu/vulkan_device.h"
#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/lsan_interface.h>
#endif

namespace fascicle::tests {

class ValidatedTest : public VulkanTest {
#if defined(__SANITIZE_ADDRESS__)
  // The layer leaks memory when it is unloaded.
  const __lsan::ScopedDisabler layer_leaks_{};
#endif

 protected:
  void SetUp() override {
#if defined(__SANITIZE_THREAD__)
    // The layer is compiled without the sanitizer, which therefore does not see how the layer's threads
    // synchronise, and reports that one frees what another has just unlocked.
    GTEST_SKIP() << "SKIPPED: the thread sanitizer reports the layer's own threads";
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
