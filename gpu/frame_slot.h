// What each frame in flight owns: the drive's upload, the results' readback, commands and a fence.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "gpu/command.h"
#include "gpu/model_buffers.h"
#include "gpu/stage_kernels.h"
#include "gpu/submission_pace.h"

namespace fascicle::gpu {

// The most frames in flight. More would hide no more of the host's time.
inline constexpr std::size_t most_frames_in_flight = 4;

// Device memory, in bytes, for the results of one frame if all of them are read.
std::uint64_t readback_bytes(const Device::Impl& device, const model::Model& model);

class FrameSlot {
 public:
  FrameSlot(Device::Impl& device, const StageKernels& kernels, const ModelBuffers& buffers);

  // Prepares the slot for a new frame: grows buffers as needed and writes the drive to the upload buffer. The
  // slot's previous frame must be done.
  void prepare(const model::Drive& drive, model::Read what, std::uint32_t vertices,
               std::uint32_t surface_vertices);

  const Kernel& kernel(StageKernel kernel) const { return (*kernels_)[kernel]; }
  std::uint32_t slices_per_group() const { return kernels_->slices_per_group(); }
  VkDescriptorSet set(StageKernel kernel, bool swapped) const {
    return sets_[2 * static_cast<std::uint32_t>(kernel) + (swapped ? 1 : 0)];
  }

  // Whether any result of the frame is read.
  bool has_results() const { return results_bytes_ > 0; }
  // Records the copy of the drive to the device, and of results to the host.
  void record_upload(CommandBuffer& commands) const;
  void record_readback(CommandBuffer& commands, bool swapped) const;

  // Waits for the frame and returns its results. The fence stays signalled: if this throws, for lack of
  // memory, it can be called again.
  model::Frame finish(SubmissionPace& pace);

  std::uint64_t index = 0;
  std::array<double, 3> origin{};
  CommandPool pool;
  Fence fence;
  Timestamps timestamps;
  std::vector<std::uint64_t> slices_of_submission;

 private:
  static constexpr std::size_t drive_parts = 5;  // bones, muscles, forces, colliders, decay
  struct Section {
    VkDeviceSize offset = 0, bytes = 0;
    bool operator==(const Section&) const = default;
  };
  using Sections = std::array<Section, drive_parts>;

  Sections lay_out(const model::Drive& drive) const;
  void make_sets();

  Device::Impl* device_;
  const StageKernels* kernels_;
  const ModelBuffers* buffers_;
  Buffer upload_, drive_, readback_;
  Sections sections_{};
  VkDeviceSize drive_bytes_ = 0;
  std::optional<DescriptorPool> descriptors_;
  std::array<VkDescriptorSet, 2 * stage_kernel_count> sets_{};
  bool are_sets_valid_ = false;  // for sections_ of drive_
  model::Read what_;
  VkDeviceSize vertex_bytes_ = 0, surface_bytes_ = 0, results_bytes_ = 0;
};

}  // namespace fascicle::gpu
