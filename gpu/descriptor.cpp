#include "gpu/descriptor.h"

#include <vector>

namespace fascicle::gpu {

DescriptorPool::DescriptorPool(const Device::Impl& device, std::uint32_t sets) : device_(&device) {
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, sets * most_buffers_of_a_kernel};
  VkDescriptorPoolCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO;
  info.maxSets = sets;
  info.poolSizeCount = 1;
  info.pPoolSizes = &size;
  VkDescriptorPool pool = VK_NULL_HANDLE;
  VULKAN_CHECK(device.call.vkCreateDescriptorPool(device.device, &info, nullptr, &pool));
  pool_ = {device.device, pool, device.call.vkDestroyDescriptorPool};
}

VkDescriptorSet DescriptorPool::make_set(const Kernel& kernel, const BufferTable& table) {
  const VkDescriptorSetLayout layout = kernel.set_layout();
  VkDescriptorSetAllocateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO;
  info.descriptorPool = pool_.get();
  info.descriptorSetCount = 1;
  info.pSetLayouts = &layout;
  VkDescriptorSet set = VK_NULL_HANDLE;
  VULKAN_CHECK(device_->call.vkAllocateDescriptorSets(device_->device, &info, &set));

  std::vector<VkWriteDescriptorSet> writes;
  for (const std::uint32_t b : kernel.buffers()) {
    VkWriteDescriptorSet write{};
    write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
    write.dstSet = set;
    write.dstBinding = b;
    write.descriptorCount = 1;
    write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    write.pBufferInfo = &table[b];
    writes.push_back(write);
  }
  device_->call.vkUpdateDescriptorSets(device_->device, static_cast<std::uint32_t>(writes.size()),
                                       writes.data(), 0, nullptr);
  return set;
}

}  // namespace fascicle::gpu
