// Records a frame's stages into submissions, none of which runs long: dispatch each stage, then finish.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>

#include "gpu/frame_slot.h"

namespace fascicle::gpu {

// Where work is cut.
struct SubmissionLimits {
  std::uint64_t slices_per_submission = std::numeric_limits<std::uint64_t>::max();
  std::uint32_t groups_per_dispatch = std::numeric_limits<std::uint32_t>::max();
};

struct RecorderOptions {
  SubmissionLimits limits;
  bool with_barriers = true;
  std::function<void(std::uint64_t slices)> on_submission = {};
  std::function<void(std::uint32_t groups)> on_dispatch = {};
};

class FrameRecorder {
 public:
  // The options outlive the recorder. The slot's submissions are cut by its pace too, if that is less.
  FrameRecorder(Device::Impl& device, FrameSlot& slot, const SubmissionPace& pace,
                const RecorderOptions& options);

  // One invocation an item. It waits for those recorded before where the schedule's accesses say that it must
  // (host/model/substep_plan.h); parts of one dispatch need not wait for each other.
  void dispatch(StageKernel kernel, bool swapped, const shader::Substep& substep, std::uint32_t items,
                const shader::ImplicitStep& implicit = {});

  // Begins a frame. Copies of the drive need not wait for the frames before: they go to the slot's own
  // buffer.
  void upload_drive();
  // `swapped`: of the frame's last dispatch.
  void read_results(bool swapped);

  // Submits what was recorded; the slot's fence is signalled when all of the frame is done.
  void finish();
  // Submits what was recorded so far and waits until the device has done it.
  void wait();

 private:
  // What is recorded next, without a wait for what came before.
  CommandBuffer& open_commands();
  // The same, after what was submitted before and the host's writes.
  CommandBuffer& commands();
  void submit(VkFence fence);
  void wait_for_dispatches();

  Device::Impl& device_;
  FrameSlot& slot_;
  const RecorderOptions& options_;
  std::uint64_t allowed_slices_;  // in a submission
  std::uint64_t allowed_groups_;  // in a dispatch
  std::optional<CommandBuffer> open_;
  std::uint64_t recorded_ = 0;      // slices in the open submission
  model::FieldSet read_, written_;  // by dispatches since the last barrier
};

}  // namespace fascicle::gpu
