#include "gpu/frame_recorder.h"

#include <algorithm>
#include <cassert>

namespace fascicle::gpu {

FrameRecorder::FrameRecorder(Device::Impl& device, FrameSlot& slot, const SubmissionPace& pace,
                             const RecorderOptions& options)
    : device_(device),
      slot_(slot),
      options_(options),
      allowed_slices_(std::min(pace.slices_per_submission(), options.limits.slices_per_submission)),
      allowed_groups_(std::min(device.info().max_groups, options.limits.groups_per_dispatch)) {
  assert(allowed_slices_ > 0 && allowed_groups_ > 0);
}

CommandBuffer& FrameRecorder::open_commands() {
  if (!open_) {
    open_.emplace(device_, slot_.pool);
    open_->begin_timing(slot_.timestamps, static_cast<std::uint32_t>(slot_.slices_of_submission.size()));
  }
  return *open_;
}

CommandBuffer& FrameRecorder::commands() {
  const bool is_new = !open_;
  CommandBuffer& commands = open_commands();
  if (is_new) commands.barrier();
  return commands;
}

void FrameRecorder::submit(VkFence fence) {
  commands().end_timing(slot_.timestamps, static_cast<std::uint32_t>(slot_.slices_of_submission.size()));
  open_->submit(fence);
  slot_.slices_of_submission.push_back(recorded_);
  if (options_.on_submission) options_.on_submission(recorded_);
  open_.reset();
  recorded_ = 0;
  read_ = written_ = {};  // the next submission begins with a barrier
}

void FrameRecorder::dispatch(StageKernel kernel, bool swapped, const shader::Substep& substep,
                             std::uint32_t items, const shader::ImplicitStep& implicit) {
  const std::uint32_t slices = items / shader::slice_width + (items % shader::slice_width != 0 ? 1 : 0);
  shader::Push push{substep, 0, implicit};
  const model::KernelAccess& access = access_of(kernel);
  while (push.first_slice < slices) {
    if (recorded_ >= allowed_slices_) submit(VK_NULL_HANDLE);
    if (push.first_slice == 0 && must_wait(access, read_, written_)) wait_for_dispatches();
    const std::uint32_t left = slices - push.first_slice, of_group = slot_.slices_per_group();
    // Workgroups are not split, as the second part would be computed twice.
    const std::uint64_t room = std::max<std::uint64_t>((allowed_slices_ - recorded_) / of_group, 1);
    const auto groups = static_cast<std::uint32_t>(
        std::min({room, allowed_groups_, std::uint64_t{left / of_group + (left % of_group != 0 ? 1 : 0)}}));
    const auto done =
        static_cast<std::uint32_t>(std::min<std::uint64_t>(std::uint64_t{groups} * of_group, left));
    commands().dispatch(slot_.kernel(kernel), slot_.set(kernel, swapped), push, groups);
    read_ = read_ | access.reads();
    written_ = written_ | access.writes;
    if (options_.on_dispatch) options_.on_dispatch(groups);
    push.first_slice += done;
    recorded_ += done;
  }
}

void FrameRecorder::upload_drive() {
  CommandBuffer& commands = open_commands();
  slot_.record_upload(commands);
  commands.barrier();
}

void FrameRecorder::wait_for_dispatches() {
  if (options_.with_barriers) commands().barrier();
  read_ = written_ = {};
}

void FrameRecorder::read_results(bool swapped) {
  if (!slot_.has_results()) return;
  if (!written_.empty()) wait_for_dispatches();
  slot_.record_readback(commands(), swapped);
}

void FrameRecorder::finish() {
  submit(slot_.fence.get());
}

void FrameRecorder::wait() {
  const Fence fence(device_);
  submit(fence.get());
  fence.wait();
}

}  // namespace fascicle::gpu
