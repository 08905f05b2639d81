// Commands for the device: pool, buffer, fence, timestamps.
#pragma once

#include <cstdint>
#include <optional>

#include "gpu/buffer.h"
#include "gpu/kernel.h"
#include "gpu/owned.h"
#include "shaders/buffers.h"

namespace fascicle::gpu {

class CommandPool {
 public:
  explicit CommandPool(const Device::Impl& device);
  VkCommandPool get() const { return pool_.get(); }
  // Frees the memory of all command buffers allocated from the pool; none may be in use.
  void reset();

 private:
  const Device::Impl* device_;
  Owned<VkCommandPool> pool_;
};

class Fence {
 public:
  explicit Fence(Device::Impl& device);
  VkFence get() const { return fence_.get(); }
  void wait() const;
  void reset() const;

 private:
  Device::Impl* device_;
  Owned<VkFence> fence_;
};

// Start and end times of command buffers.
class Timestamps {
 public:
  Timestamps(const Device::Impl& device, std::uint32_t pairs);
  VkQueryPool get() const { return pool_.get(); }
  std::uint32_t pairs() const { return pairs_; }
  // Nanoseconds between the two times of a pair; nothing until the device has finished it.
  std::optional<double> elapsed(std::uint32_t pair) const;

 private:
  const Device::Impl* device_;
  std::uint32_t pairs_;
  Owned<VkQueryPool> pool_;
};

// A command buffer: recorded once, submitted once, freed by its pool. Construction begins the recording.
class CommandBuffer {
 public:
  CommandBuffer(Device::Impl& device, const CommandPool& pool);

  void begin_timing(const Timestamps& timestamps, std::uint32_t pair);
  void end_timing(const Timestamps& timestamps, std::uint32_t pair);
  // Everything recorded or submitted before completes, and its writes are visible, before what follows
  // starts.
  void barrier();
  // Makes copies recorded before visible to the host once it has waited for a fence.
  void barrier_to_host();
  void copy(const Buffer& from, VkDeviceSize from_offset, const Buffer& to, VkDeviceSize to_offset,
            VkDeviceSize bytes);
  void dispatch(const Kernel& kernel, VkDescriptorSet set, const shader::Push& push, std::uint32_t groups);

  void submit(VkFence fence);
  void submit_and_wait();

 private:
  Device::Impl* device_;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
};

}  // namespace fascicle::gpu
