// The device buffers of a model and of a solver's state.
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

// All buffers of a model and its state; allocates none.
std::vector<PlannedBuffer> plan_buffers(const model::Model& model);

// Throws DeviceError, with the numbers, if a buffer exceeds maxStorageBufferRange, or if all buffers plus the
// frames in flight exceed the memory.
void check_plan(const std::vector<PlannedBuffer>& plan, std::uint64_t frames_in_flight_bytes,
                const DeviceInfo& device);

class ModelBuffers {
 public:
  // Allocates all buffers and fills the static ones.
  ModelBuffers(Device::Impl& device, const model::Model& model);

  const Buffer& operator[](std::uint32_t number) const { return buffers_[number]; }
  // The buffer table for kernels. `swapped` exchanges buffer_skinned and buffer_skinned_before.
  BufferTable table(bool swapped) const;

 private:
  std::array<Buffer, shader::buffer_count> buffers_;
};

// Convert between 3n floats and the 4n floats of a buffer with one vec4 per item.
std::vector<float> widened(const std::vector<float>& triples);
void narrow(std::span<const float> records, std::vector<float>& triples);

}  // namespace fascicle::gpu
