// A Vulkan buffer and its memory.
#pragma once

#include <cstddef>
#include <span>

#include "gpu/device_impl.h"
#include "gpu/owned.h"

namespace fascicle::gpu {

enum class BufferUse {
  storage,   // lives on the device; shaders read and write it
  upload,    // the host writes it, then it is copied to the device
  readback,  // the device copies into it, then the host reads
};

// Whether a buffer for this use takes device memory. Upload and readback buffers do if host and device share
// memory.
bool takes_device_memory(const Device::Impl& device, BufferUse use);

class Buffer {
 public:
  Buffer() = default;
  // Allocates at least 16 bytes, so that an empty buffer can still be bound.
  Buffer(const Device::Impl& device, VkDeviceSize bytes, BufferUse use);

  VkBuffer get() const { return buffer_.get(); }
  VkDeviceSize size() const { return size_; }
  // The memory of an upload or readback buffer; coherent, mapped for the buffer's lifetime.
  std::span<std::byte> host() const { return host_; }

 private:
  Owned<VkDeviceMemory> memory_;
  Owned<VkBuffer> buffer_;  // after memory_: destroyed first
  VkDeviceSize size_ = 0;
  std::span<std::byte> host_;
};

// Writes to a storage buffer and waits until the copy is done.
void write_buffer(Device::Impl& device, const Buffer& to, std::span<const std::byte> bytes);
// Reads the first bytes.size() bytes, after all work submitted so far.
void read_buffer(Device::Impl& device, const Buffer& from, std::span<std::byte> bytes);

}  // namespace fascicle::gpu
