#include "gpu/buffer.h"

#include <algorithm>
#include <cstring>
#include <string>

#include "gpu/command.h"

namespace fascicle::gpu {
namespace {

// Size of a staging buffer: a submission that copies 16 MiB is short on any device.
constexpr VkDeviceSize staging_bytes = VkDeviceSize{16} << 20;

VkBufferUsageFlags usage_of(BufferUse use) {
  switch (use) {
    case BufferUse::storage:
      return VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT |
             VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    case BufferUse::upload:
      return VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
    case BufferUse::readback:
      return VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  }
  return 0;
}

std::uint32_t memory_type_of(const Device::Impl& device, std::uint32_t types, BufferUse use) {
  constexpr VkMemoryPropertyFlags coherent =
      VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  switch (use) {
    case BufferUse::storage:
      return device.memory_type(types, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, 0);
    case BufferUse::upload:
      return device.memory_type(types, coherent, coherent);
    case BufferUse::readback:
      return device.memory_type(types, coherent | VK_MEMORY_PROPERTY_HOST_CACHED_BIT, coherent);
  }
  return 0;
}

}  // namespace

bool takes_device_memory(const Device::Impl& device, BufferUse use) {
  const VkPhysicalDeviceMemoryProperties& memory = device.physical.memory;
  // The allowed types are known only once a buffer exists; this considers all of them.
  const std::uint32_t type = memory_type_of(device, ~0u, use);
  return (memory.memoryHeaps[memory.memoryTypes[type].heapIndex].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) !=
         0;
}

Buffer::Buffer(const Device::Impl& device, VkDeviceSize bytes, BufferUse use)
    : size_(std::max<VkDeviceSize>(bytes, 16)) {
  VkBufferCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
  info.size = size_;
  info.usage = usage_of(use);
  info.sharingMode = VK_SHARING_MODE_EXCLUSIVE;
  VkBuffer buffer = VK_NULL_HANDLE;
  VULKAN_CHECK(device.call.vkCreateBuffer(device.device, &info, nullptr, &buffer));
  Owned<VkBuffer> owned_buffer(device.device, buffer, device.call.vkDestroyBuffer);

  VkMemoryRequirements requirements{};
  device.call.vkGetBufferMemoryRequirements(device.device, buffer, &requirements);
  VkMemoryAllocateInfo allocation{};
  allocation.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
  allocation.allocationSize = requirements.size;
  allocation.memoryTypeIndex = memory_type_of(device, requirements.memoryTypeBits, use);
  VkDeviceMemory memory = VK_NULL_HANDLE;
  const VkResult allocated = device.call.vkAllocateMemory(device.device, &allocation, nullptr, &memory);
  if (allocated != VK_SUCCESS)
    check(allocated, ("vkAllocateMemory of " + std::to_string(requirements.size) + " bytes").c_str());
  memory_ = Owned<VkDeviceMemory>(device.device, memory, device.call.vkFreeMemory);
  buffer_ = std::move(owned_buffer);
  VULKAN_CHECK(device.call.vkBindBufferMemory(device.device, buffer, memory, 0));

  if (use == BufferUse::storage) return;
  void* mapped = nullptr;
  VULKAN_CHECK(device.call.vkMapMemory(device.device, memory, 0, VK_WHOLE_SIZE, 0, &mapped));
  host_ = {static_cast<std::byte*>(mapped), static_cast<std::size_t>(size_)};
}

void write_buffer(Device::Impl& device, const Buffer& to, std::span<const std::byte> bytes) {
  if (bytes.empty()) return;
  const Buffer staging(device, std::min<VkDeviceSize>(bytes.size(), staging_bytes), BufferUse::upload);
  const CommandPool pool(device);
  for (std::size_t at = 0; at < bytes.size(); at += staging.size()) {
    const std::size_t count = std::min<std::size_t>(bytes.size() - at, staging.size());
    std::memcpy(staging.host().data(), bytes.data() + at, count);
    CommandBuffer commands(device, pool);
    commands.barrier();
    commands.copy(staging, 0, to, at, count);
    commands.submit_and_wait();
  }
}

void read_buffer(Device::Impl& device, const Buffer& from, std::span<std::byte> bytes) {
  if (bytes.empty()) return;
  const Buffer staging(device, std::min<VkDeviceSize>(bytes.size(), staging_bytes), BufferUse::readback);
  const CommandPool pool(device);
  for (std::size_t at = 0; at < bytes.size(); at += staging.size()) {
    const std::size_t count = std::min<std::size_t>(bytes.size() - at, staging.size());
    CommandBuffer commands(device, pool);
    commands.barrier();
    commands.copy(from, at, staging, 0, count);
    commands.barrier_to_host();
    commands.submit_and_wait();
    std::memcpy(bytes.data() + at, staging.host().data(), count);
  }
}

}  // namespace fascicle::gpu
