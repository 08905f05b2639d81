// Records a frame's stages into submissions none of which runs long.
#pragma once

#include <cstdint>
#include <optional>

#include "gpu/frame_slot.h"

namespace fascicle::gpu {

class FrameRecorder {
 public:
  // `with_barriers` false is for the test that shows the validation layer sees a missing one.
  FrameRecorder(Device::Impl& device, FrameSlot& slot, const SubmissionPace& pace, bool with_barriers)
      : device_(device), slot_(slot), allowed_(pace.slices_per_submission()), with_barriers_(with_barriers) {}

  // One invocation an item. What was recorded before is done before it, what comes later sees it.
  void dispatch(StageKernel kernel, bool swapped, const shader::Substep& substep, std::uint32_t items);

  void upload_drive();
  void read_results();

  // Submits what was recorded; the slot's fence is signalled when all of the frame is done.
  void finish();
  // Submits what was recorded so far and waits until the device has done it.
  void wait();

 private:
  CommandBuffer& commands();
  void submit(VkFence fence);

  Device::Impl& device_;
  FrameSlot& slot_;
  std::uint64_t allowed_;
  bool with_barriers_;
  std::optional<CommandBuffer> open_;
  std::uint64_t recorded_ = 0;  // slices in the open submission
};

}  // namespace fascicle::gpu
