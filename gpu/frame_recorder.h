// Records a frame's stages into submissions, each short: dispatch each stage, then finish.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>

#include "gpu/frame_slot.h"

namespace fascicle::gpu {

// Limits at which work is split.
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
  // The options must outlive the recorder. The pace limits submissions too.
  FrameRecorder(Device::Impl& device, FrameSlot& slot, const SubmissionPace& pace,
                const RecorderOptions& options);

  // One invocation per item. Waits for earlier dispatches if the schedule's accesses require it
  // (host/model/substep_plan.h); parts of one dispatch need not wait for each other.
  void dispatch(StageKernel kernel, bool swapped, const shader::Substep& substep, std::uint32_t items,
                const shader::ImplicitStep& implicit = {});

  // Begins a frame. The copy of the drive need not wait for earlier frames, as it goes to the slot's own
  // buffer.
  void upload_drive();
  // `swapped`: that of the frame's last dispatch.
  void read_results(bool swapped);

  // Submits what was recorded; the slot's fence is signalled once the whole frame is done.
  void finish();
  // Submits what was recorded so far and waits until it is done.
  void wait();

 private:
  // The open command buffer, or a new one that does not wait for earlier work.
  CommandBuffer& open_commands();
  // The same, but a new one waits for earlier submissions and the host's writes.
  CommandBuffer& commands();
  void submit(VkFence fence);
  void wait_for_dispatches();

  Device::Impl& device_;
  FrameSlot& slot_;
  const RecorderOptions& options_;
  std::uint64_t allowed_slices_;  // per submission
  std::uint64_t allowed_groups_;  // per dispatch
  std::optional<CommandBuffer> open_;
  std::uint64_t recorded_ = 0;      // slices in the open submission
  model::FieldSet read_, written_;  // by dispatches since the last barrier
};

}  // namespace fascicle::gpu
