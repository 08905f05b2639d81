// Descriptor sets: bind a buffer to each binding number of shaders/buffers.h.
#pragma once

#include <array>
#include <cstdint>

#include "gpu/buffer.h"
#include "gpu/kernel.h"
#include "gpu/owned.h"
#include "shaders/buffers.h"

namespace fascicle::gpu {

// The buffers by number; entries that a kernel does not use may stay empty.
using BufferTable = std::array<VkDescriptorBufferInfo, shader::buffer_count>;

inline VkDescriptorBufferInfo whole(const Buffer& buffer) {
  return {buffer.get(), 0, VK_WHOLE_SIZE};
}

class DescriptorPool {
 public:
  // Room for `sets` sets of `most_buffers_of_a_kernel` buffers.
  DescriptorPool(const Device::Impl& device, std::uint32_t sets);

  // A set for the kernel with the table's buffers. It lives as long as the pool.
  VkDescriptorSet make_set(const Kernel& kernel, const BufferTable& table);

 private:
  const Device::Impl* device_;
  Owned<VkDescriptorPool> pool_;
};

}  // namespace fascicle::gpu
