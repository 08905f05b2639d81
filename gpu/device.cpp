#include "gpu/device.h"

#include <cstring>
#include <string>

#include "gpu/device_impl.h"
#include "gpu/self_test.h"

namespace fascicle::gpu {
namespace {

PhysicalDevice find_device(const Instance& instance, std::uint32_t index) {
  const std::vector<VkPhysicalDevice> devices = instance.physical_devices();
  if (index >= devices.size())
    throw DeviceError("there is no Vulkan device " + std::to_string(index) + "; this machine has " +
                      std::to_string(devices.size()));
  PhysicalDevice device = describe(devices[index], index);
  if (!device.info.usable)
    throw DeviceError("Vulkan device " + std::to_string(index) + " (" + device.info.name +
                      ") cannot be used: " + device.info.why_not);
  return device;
}

// Drivers may crash on a pipeline cache that is not their own.
bool is_pipelines_of(const PhysicalDevice& device, const std::string& bytes) {
  VkPipelineCacheHeaderVersionOne header{};
  if (bytes.size() < sizeof header) return false;
  std::memcpy(&header, bytes.data(), sizeof header);
  return header.headerSize == sizeof header && header.headerVersion == VK_PIPELINE_CACHE_HEADER_VERSION_ONE &&
         pipelines_key(header.vendorID, header.deviceID, header.pipelineCacheUUID) ==
             device.info.pipelines_key;
}

}  // namespace

std::vector<DeviceInfo> list_devices(std::string* why_none) {
  std::vector<DeviceInfo> infos;
  std::string why;
  try {
    const Instance instance(DeviceOptions{});
    for (const VkPhysicalDevice handle : instance.physical_devices())
      infos.push_back(describe(handle, static_cast<std::uint32_t>(infos.size())).info);
    why = "the Vulkan loader found no device; is a driver installed?";
  } catch (const DeviceError& error) {
    // A loader without any driver fails here; pass its reason on.
    infos.clear();
    why = error.what();
  }
  if (why_none) *why_none = infos.empty() ? why : std::string();
  return infos;
}

Device::Impl::Impl(std::uint32_t index, const DeviceOptions& options)
    : instance(options), physical(find_device(instance, index)) {
  const float priority = 1.0f;
  VkDeviceQueueCreateInfo queue_info{};
  queue_info.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
  queue_info.queueFamilyIndex = physical.queue_family;
  queue_info.queueCount = 1;
  queue_info.pQueuePriorities = &priority;

  const char* extension = VK_KHR_SHADER_FLOAT_CONTROLS_EXTENSION_NAME;
  VkDeviceCreateInfo device_info{};
  device_info.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
  device_info.queueCreateInfoCount = 1;
  device_info.pQueueCreateInfos = &queue_info;
  device_info.enabledExtensionCount = physical.float_controls_extension ? 1 : 0;
  device_info.ppEnabledExtensionNames = &extension;
  VULKAN_CHECK(vkCreateDevice(physical.handle, &device_info, nullptr, &device));
  volkLoadDeviceTable(&call, device);
  owned_device_ = {device, Destroy{call.vkDestroyDevice}};
  call.vkGetDeviceQueue(device, physical.queue_family, 0, &queue);

  VkPipelineCacheCreateInfo cache_info{};
  cache_info.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO;
  if (is_pipelines_of(physical, options.pipelines)) {
    cache_info.initialDataSize = options.pipelines.size();
    cache_info.pInitialData = options.pipelines.data();
  }
  VkPipelineCache cache = VK_NULL_HANDLE;
  VULKAN_CHECK(call.vkCreatePipelineCache(device, &cache_info, nullptr, &cache));
  pipelines = {device, cache, call.vkDestroyPipelineCache};
}

Device::Impl::~Impl() {
  call.vkDeviceWaitIdle(device);  // a destructor cannot report an error
}

spirv_exact::FloatControls Device::Impl::float_controls() const {
  return {info().rounding_rte, info().signed_zero_inf_nan_preserve};
}

void Device::Impl::submit(VkCommandBuffer commands, VkFence fence) {
  VkSubmitInfo info{};
  info.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
  info.commandBufferCount = 1;
  info.pCommandBuffers = &commands;
  const std::scoped_lock lock(queue_mutex_);
  VULKAN_CHECK(call.vkQueueSubmit(queue, 1, &info, fence));
}

void Device::Impl::wait_idle() {
  const std::scoped_lock lock(queue_mutex_);
  VULKAN_CHECK(call.vkQueueWaitIdle(queue));
}

std::uint32_t Device::Impl::memory_type(std::uint32_t types, VkMemoryPropertyFlags wanted,
                                        VkMemoryPropertyFlags needed) const {
  for (const VkMemoryPropertyFlags flags : {wanted, needed})
    for (std::uint32_t t = 0; t < physical.memory.memoryTypeCount; ++t)
      if ((types & (1u << t)) && (physical.memory.memoryTypes[t].propertyFlags & flags) == flags) return t;
  throw DeviceError("device " + info().name + " has no memory type that a buffer needs");
}

Device::Device(std::uint32_t index, const DeviceOptions& options)
    : impl_(std::make_unique<Impl>(index, options)) {}
Device::~Device() = default;

const DeviceInfo& Device::info() const {
  return impl_->info();
}

std::string Device::pipelines() const {
  std::string bytes;
  for (VkResult result = VK_INCOMPLETE; result == VK_INCOMPLETE;) {
    // Another thread may add pipelines between the two calls.
    std::size_t size = 0;
    VULKAN_CHECK(impl_->call.vkGetPipelineCacheData(impl_->device, impl_->pipelines.get(), &size, nullptr));
    bytes.resize(size);
    result = impl_->call.vkGetPipelineCacheData(impl_->device, impl_->pipelines.get(), &size, bytes.data());
    check(result, "vkGetPipelineCacheData");
    bytes.resize(size);
  }
  return bytes;
}

bool Device::self_test(std::string* why) {
  const std::string difference = first_self_test_difference(
      run_self_test(*impl_, shader::module_of("self_test"), impl_->float_controls()));
  if (why) *why = difference;
  return difference.empty();
}

}  // namespace fascicle::gpu
