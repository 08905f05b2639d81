// A buffer with its memory.
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

// Whether such a buffer takes device memory: an upload or readback buffer does where host and device share
// theirs.
bool takes_device_memory(const Device::Impl& device, BufferUse use);

class Buffer {
 public:
  Buffer() = default;
  // At least 16 bytes are made, so that a buffer that holds nothing can still be bound.
  Buffer(const Device::Impl& device, VkDeviceSize bytes, BufferUse use);

  VkBuffer get() const { return buffer_.get(); }
  VkDeviceSize size() const { return size_; }
  // The memory of an upload or readback buffer; coherent, mapped as long as the buffer lives.
  std::span<std::byte> host() const { return host_; }

 private:
  Owned<VkDeviceMemory> memory_;
  Owned<VkBuffer> buffer_;  // after memory_: destroyed first
  VkDeviceSize size_ = 0;
  std::span<std::byte> host_;
};

// Waits until the bytes are there. The buffer is a storage buffer; offsets in bytes.
void write_buffer(Device::Impl& device, const Buffer& to, std::span<const std::byte> bytes);
// Reads bytes.size() bytes from the start, after all work submitted so far.
void read_buffer(Device::Impl& device, const Buffer& from, std::span<std::byte> bytes);

}  // namespace fascicle::gpu
