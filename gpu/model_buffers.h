// The buffers that hold a model and a solver's state on the device.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "gpu/buffer.h"
#include "gpu/descriptor.h"
#include "host/model/solver.h"

namespace fascicle::gpu {

struct PlannedBuffer {
  std::uint32_t number;  // of shaders/buffers.h
  const char* name;
  std::uint64_t bytes;
};

// All buffers of a model and its state, without making any.
std::vector<PlannedBuffer> plan_buffers(const model::Model& model);

// Throws DeviceError, with the numbers, if a buffer is over maxStorageBufferRange, or all together and the
// frames in flight are over the memory.
void check_plan(const std::vector<PlannedBuffer>& plan, std::uint64_t frames_in_flight_bytes,
                const DeviceInfo& device);

class ModelBuffers {
 public:
  // Makes all buffers and fills the static ones.
  ModelBuffers(Device::Impl& device, const model::Model& model);

  const Buffer& operator[](std::uint32_t number) const { return buffers_[number]; }
  // The table for kernels. With `swapped`, buffer_skinned and buffer_skinned_before change places.
  BufferTable table(bool swapped) const;

 private:
  std::array<Buffer, shader::buffer_count> buffers_;
};

// 3n or 4n floats to and from buffers of one vec4 an item.
std::vector<float> widened(const std::vector<float>& triples);
void narrow(std::span<const float> records, std::vector<float>& triples);

}  // namespace fascicle::gpu
