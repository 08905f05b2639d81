// A physical device and its capabilities.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <volk.h>

#include "gpu/device.h"

namespace fascicle::gpu {

// Number of buffers that the largest kernel (update) binds. A test compares it with the shaders.
inline constexpr std::uint32_t most_buffers_of_a_kernel = 20;

struct PhysicalDevice {
  VkPhysicalDevice handle = VK_NULL_HANDLE;
  DeviceInfo info;
  VkPhysicalDeviceLimits limits{};
  VkPhysicalDeviceMemoryProperties memory{};
  std::uint32_t queue_family = 0;  // one that supports compute
  bool has_timestamps = false;     // on that family
  bool float_controls_extension = false;
};

// DeviceInfo::pipelines_key for these numbers; `driver`: VkPhysicalDeviceProperties' pipelineCacheUUID, which
// changes with the driver.
std::string pipelines_key(std::uint32_t vendor, std::uint32_t device,
                          std::span<const std::uint8_t, VK_UUID_SIZE> driver);

PhysicalDevice describe(VkPhysicalDevice handle, std::uint32_t index);

}  // namespace fascicle::gpu
