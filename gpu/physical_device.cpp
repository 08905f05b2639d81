#include "gpu/physical_device.h"

#include <algorithm>
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

// The first family with compute; one without graphics is preferred, as it does not share a queue with a
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

}  // namespace

PhysicalDevice describe(VkPhysicalDevice handle, std::uint32_t index) {
  PhysicalDevice device;
  device.handle = handle;
  DeviceInfo& info = device.info;

  const Extensions extensions(handle);
  VkPhysicalDeviceSubgroupProperties subgroup{};
  subgroup.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES;
  VkPhysicalDeviceFloatControlsProperties controls{};
  controls.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FLOAT_CONTROLS_PROPERTIES;
  VkPhysicalDeviceDriverProperties driver{};
  driver.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES;
  VkPhysicalDeviceProperties2 properties{};
  properties.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;

  VkPhysicalDeviceProperties core{};
  vkGetPhysicalDeviceProperties(handle, &core);
  const bool modern = core.apiVersion >= VK_API_VERSION_1_1;
  if (modern) {
    void** last = &properties.pNext;
    const auto chain = [&](auto& structure) {
      *last = &structure;
      last = &structure.pNext;
    };
    chain(subgroup);
    device.float_controls_extension = extensions.contains(VK_KHR_SHADER_FLOAT_CONTROLS_EXTENSION_NAME);
    if (device.float_controls_extension) chain(controls);
    if (extensions.contains(VK_KHR_DRIVER_PROPERTIES_EXTENSION_NAME)) chain(driver);
    vkGetPhysicalDeviceProperties2(handle, &properties);
  }
  vkGetPhysicalDeviceMemoryProperties(handle, &device.memory);
  device.limits = core.limits;

  info.index = index;
  info.name = core.deviceName;
  info.type = type_text(core.deviceType);
  info.software = core.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
  info.driver = driver.driverName[0] != '\0' ? std::string(driver.driverName) + " " + driver.driverInfo
                                             : std::to_string(core.driverVersion);
  info.api_version = version_text(core.apiVersion);
  for (std::uint32_t h = 0; h < device.memory.memoryHeapCount; ++h)
    if (device.memory.memoryHeaps[h].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT)
      info.memory = std::max<std::uint64_t>(info.memory, device.memory.memoryHeaps[h].size);
  info.max_storage_buffer_range = core.limits.maxStorageBufferRange;
  info.max_groups = core.limits.maxComputeWorkGroupCount[0];
  info.subgroup_size = subgroup.subgroupSize;
  // Where widths depend on each other, a mode for 32 bits alone is not allowed.
  const bool rounding_alone = controls.roundingModeIndependence != VK_SHADER_FLOAT_CONTROLS_INDEPENDENCE_NONE;
  info.rounding_rte = controls.shaderRoundingModeRTEFloat32 && rounding_alone;
  info.signed_zero_inf_nan_preserve = controls.shaderSignedZeroInfNanPreserveFloat32;
  info.denorm_preserve = controls.shaderDenormPreserveFloat32;

  std::uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(handle, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(handle, &count, families.data());
  const std::optional<std::uint32_t> family = compute_family(families);
  if (family) {
    device.queue_family = *family;
    device.has_timestamps = families[*family].timestampValidBits > 0;
  }

  const auto refuse = [&](const std::string& why) {
    if (info.usable) info.why_not = why;
    info.usable = false;
  };
  if (!modern) refuse("it knows Vulkan " + info.api_version + " only; 1.1 is needed");
  if (!family) refuse("it has no compute queue");
  const std::uint32_t buffers = core.limits.maxPerStageDescriptorStorageBuffers;
  if (buffers < most_buffers_of_a_kernel)
    refuse("it binds " + std::to_string(buffers) +
           " buffers to a shader (maxPerStageDescriptorStorageBuffers); " +
           std::to_string(most_buffers_of_a_kernel) + " are needed");
  if (core.limits.maxPushConstantsSize < sizeof(shader::Push))
    refuse("it has " + std::to_string(core.limits.maxPushConstantsSize) + " bytes of push constants; " +
           std::to_string(sizeof(shader::Push)) + " are needed");
  return device;
}

}  // namespace fascicle::gpu
