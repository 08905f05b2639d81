#include "gpu/physical_device.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string>

#include "gpu/check.h"
#include "shaders/buffers.h"

namespace fascicle::gpu {
namespace {

std::string version_text(std::uint32_t version) {
  return std::to_string(VK_API_VERSION_MAJOR(version)) + "." + std::to_string(VK_API_VERSION_MINOR(version)) +
         "." + std::to_string(VK_API_VERSION_PATCH(version));
}

std::string type_text(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      return "discrete";
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      return "integrated";
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
      return "virtual";
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
      return "cpu";
    default:
      return "other";
  }
}

class Extensions {
 public:
  explicit Extensions(VkPhysicalDevice handle) {
    std::uint32_t count = 0;
    VULKAN_CHECK(vkEnumerateDeviceExtensionProperties(handle, nullptr, &count, nullptr));
    properties_.resize(count);
    VULKAN_CHECK(vkEnumerateDeviceExtensionProperties(handle, nullptr, &count, properties_.data()));
  }
  bool contains(const char* name) const {
    return std::any_of(properties_.begin(), properties_.end(), [&](const VkExtensionProperties& p) {
      return std::strcmp(p.extensionName, name) == 0;
    });
  }

 private:
  std::vector<VkExtensionProperties> properties_;
};

// The first family with compute. One without graphics is preferred, as it does not share a queue with the
// display.
std::optional<std::uint32_t> compute_family(const std::vector<VkQueueFamilyProperties>& families) {
  std::optional<std::uint32_t> found;
  for (std::uint32_t f = 0; f < families.size(); ++f) {
    if (families[f].queueCount == 0 || !(families[f].queueFlags & VK_QUEUE_COMPUTE_BIT)) continue;
    if (!(families[f].queueFlags & VK_QUEUE_GRAPHICS_BIT)) return f;
    if (!found) found = f;
  }
  return found;
}

// Properties of a Vulkan 1.1 device beyond the core ones. An older device leaves them all at zero.
struct MoreProperties {
  VkPhysicalDeviceSubgroupProperties subgroup{};
  VkPhysicalDeviceFloatControlsProperties controls{};
  VkPhysicalDeviceDriverProperties driver{};
};

MoreProperties more_properties(VkPhysicalDevice handle, const Extensions& extensions) {
  MoreProperties more;
  more.subgroup.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES;
  more.controls.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FLOAT_CONTROLS_PROPERTIES;
  more.driver.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES;
  VkPhysicalDeviceProperties2 properties{};
  properties.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
  void** last = &properties.pNext;
  const auto chain = [&](auto& structure) {
    *last = &structure;
    last = &structure.pNext;
  };
  chain(more.subgroup);
  if (extensions.contains(VK_KHR_SHADER_FLOAT_CONTROLS_EXTENSION_NAME)) chain(more.controls);
  if (extensions.contains(VK_KHR_DRIVER_PROPERTIES_EXTENSION_NAME)) chain(more.driver);
  vkGetPhysicalDeviceProperties2(handle, &properties);
  // The chain points to structures local to this function.
  more.subgroup.pNext = more.controls.pNext = more.driver.pNext = nullptr;
  return more;
}

std::vector<VkQueueFamilyProperties> queue_families(VkPhysicalDevice handle) {
  std::uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(handle, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(handle, &count, families.data());
  return families;
}

DeviceInfo info_of(const VkPhysicalDeviceProperties& core, const MoreProperties& more,
                   const VkPhysicalDeviceMemoryProperties& memory) {
  DeviceInfo info;
  info.name = core.deviceName;
  info.type = type_text(core.deviceType);
  info.software = core.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
  info.driver = more.driver.driverName[0] != '\0'
                    ? std::string(more.driver.driverName) + " " + more.driver.driverInfo
                    : std::to_string(core.driverVersion);
  info.api_version = version_text(core.apiVersion);
  for (std::uint32_t h = 0; h < memory.memoryHeapCount; ++h)
    if (memory.memoryHeaps[h].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT)
      info.memory = std::max<std::uint64_t>(info.memory, memory.memoryHeaps[h].size);
  info.max_storage_buffer_range = core.limits.maxStorageBufferRange;
  info.pipelines_key = pipelines_key(core.vendorID, core.deviceID, core.pipelineCacheUUID);
  info.max_groups = core.limits.maxComputeWorkGroupCount[0];
  info.subgroup_size = more.subgroup.subgroupSize;
  // If widths depend on each other, a mode for 32 bits alone is not allowed.
  const bool rounding_alone =
      more.controls.roundingModeIndependence != VK_SHADER_FLOAT_CONTROLS_INDEPENDENCE_NONE;
  info.rounding_rte = more.controls.shaderRoundingModeRTEFloat32 && rounding_alone;
  info.signed_zero_inf_nan_preserve = more.controls.shaderSignedZeroInfNanPreserveFloat32;
  info.denorm_preserve = more.controls.shaderDenormPreserveFloat32;
  return info;
}

// Why the device cannot be used; empty if it can.
std::string refusal(const VkPhysicalDeviceProperties& core, bool has_compute) {
  if (core.apiVersion < VK_API_VERSION_1_1)
    return "it supports only Vulkan " + version_text(core.apiVersion) + "; 1.1 is needed";
  if (!has_compute) return "it has no compute queue";
  const std::uint32_t buffers = core.limits.maxPerStageDescriptorStorageBuffers;
  if (buffers < most_buffers_of_a_kernel)
    return "it binds " + std::to_string(buffers) +
           " buffers to a shader (maxPerStageDescriptorStorageBuffers); " +
           std::to_string(most_buffers_of_a_kernel) + " are needed";
  if (core.limits.maxPushConstantsSize < sizeof(shader::Push))
    return "it has " + std::to_string(core.limits.maxPushConstantsSize) + " bytes of push constants; " +
           std::to_string(sizeof(shader::Push)) + " are needed";
  return {};
}

}  // namespace

std::string pipelines_key(std::uint32_t vendor, std::uint32_t device,
                          std::span<const std::uint8_t, VK_UUID_SIZE> driver) {
  std::string key;
  char digits[16];
  std::snprintf(digits, sizeof digits, "%08x", vendor);
  key += digits;
  std::snprintf(digits, sizeof digits, "%08x", device);
  key += digits;
  for (const std::uint8_t byte : driver) {
    std::snprintf(digits, sizeof digits, "%02x", byte);
    key += digits;
  }
  return key;
}

PhysicalDevice describe(VkPhysicalDevice handle, std::uint32_t index) {
  PhysicalDevice device;
  device.handle = handle;
  VkPhysicalDeviceProperties core{};
  vkGetPhysicalDeviceProperties(handle, &core);
  vkGetPhysicalDeviceMemoryProperties(handle, &device.memory);
  device.limits = core.limits;
  MoreProperties more;
  // A driver that fails must not hide the other devices, nor change their numbers.
  std::string failure;
  if (core.apiVersion >= VK_API_VERSION_1_1) {
    try {
      const Extensions extensions(handle);
      device.float_controls_extension = extensions.contains(VK_KHR_SHADER_FLOAT_CONTROLS_EXTENSION_NAME);
      more = more_properties(handle, extensions);
    } catch (const DeviceError& error) {
      failure = std::string("its driver failed: ") + error.what();
    }
  }
  device.info = info_of(core, more, device.memory);
  device.info.index = index;

  const std::vector<VkQueueFamilyProperties> families = queue_families(handle);
  const std::optional<std::uint32_t> family = compute_family(families);
  if (family) {
    device.queue_family = *family;
    device.has_timestamps = families[*family].timestampValidBits > 0;
  }
  device.info.why_not = failure.empty() ? refusal(core, family.has_value()) : failure;
  device.info.usable = device.info.why_not.empty();
  return device;
}

}  // namespace fascicle::gpu
