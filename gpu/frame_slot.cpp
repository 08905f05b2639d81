#include "gpu/frame_slot.h"

#include <algorithm>
#include <cstring>
#include <string>

namespace fascicle::gpu {
namespace {

// Timed submissions per frame; more of them teach the pace nothing new.
constexpr std::uint32_t timed_submissions = 16;

std::array<std::span<const std::byte>, 5> parts_of(const model::Drive& drive) {
  return {std::as_bytes(drive.bones), std::as_bytes(drive.muscles), std::as_bytes(drive.forces),
          std::as_bytes(drive.colliders), std::as_bytes(drive.decay)};
}

std::span<const float> floats(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const float*>(bytes.data()), bytes.size() / sizeof(float)};
}

}  // namespace

std::uint64_t readback_bytes(const Device::Impl& device, const model::Model& model) {
  if (!takes_device_memory(device, BufferUse::readback)) return 0;
  const std::uint64_t vertex_buffers = model.has_skeleton() ? 3 : 2;
  return vertex_buffers * 16 * model.vertex_count + std::uint64_t{12} * model.surface_count();
}

FrameSlot::FrameSlot(Device::Impl& device, const StageKernels& kernels, const ModelBuffers& buffers)
    : pool(device),
      fence(device),
      timestamps(device, timed_submissions),
      device_(&device),
      kernels_(&kernels),
      buffers_(&buffers) {}

FrameSlot::Sections FrameSlot::lay_out(const model::Drive& drive) const {
  const VkDeviceSize alignment =
      std::max<VkDeviceSize>(16, device_->physical.limits.minStorageBufferOffsetAlignment);
  Sections sections;
  VkDeviceSize offset = 0;
  const auto parts = parts_of(drive);
  for (std::size_t p = 0; p < parts.size(); ++p) {
    // Empty parts are bound too, and a binding cannot be empty.
    sections[p] = {offset, std::max<VkDeviceSize>(parts[p].size(), 16)};
    if (sections[p].bytes > device_->info().max_storage_buffer_range)
      throw DeviceError("a frame's poses and forces need " + std::to_string(sections[p].bytes) +
                        " bytes, but device " + device_->info().name + " binds at most " +
                        std::to_string(device_->info().max_storage_buffer_range) +
                        " (maxStorageBufferRange); use fewer substeps");
    offset = (offset + sections[p].bytes + alignment - 1) / alignment * alignment;
  }
  return sections;
}

void FrameSlot::prepare(const model::Drive& drive, model::Read what, std::uint32_t vertices,
                        std::uint32_t surface_vertices) {
  const Sections sections = lay_out(drive);
  // Anything below may fail for lack of memory, and the slot is then prepared again.
  are_sets_valid_ = are_sets_valid_ && sections == sections_;
  sections_ = sections;
  drive_bytes_ = sections.back().offset + sections.back().bytes;
  if (drive_.size() < drive_bytes_) {
    upload_ = Buffer(*device_, drive_bytes_, BufferUse::upload);
    drive_ = Buffer(*device_, drive_bytes_, BufferUse::storage);
  }
  if (!are_sets_valid_) make_sets();
  const auto parts = parts_of(drive);
  for (std::size_t p = 0; p < parts.size(); ++p)
    if (!parts[p].empty())
      std::memcpy(upload_.host().data() + sections_[p].offset, parts[p].data(), parts[p].size());

  what_ = what;
  vertex_bytes_ = VkDeviceSize{16} * vertices;
  surface_bytes_ = VkDeviceSize{12} * surface_vertices;
  results_bytes_ = (what.positions ? vertex_bytes_ : 0) + (what.velocities ? vertex_bytes_ : 0) +
                   (what.surface ? surface_bytes_ : 0) + (what.skinned ? vertex_bytes_ : 0);
  if (readback_.size() < results_bytes_) readback_ = Buffer(*device_, results_bytes_, BufferUse::readback);
  pool.reset();
  slices_of_submission.clear();
  fence.reset();
}

void FrameSlot::make_sets() {
  descriptors_.emplace(*device_, static_cast<std::uint32_t>(sets_.size()));
  constexpr std::array<std::uint32_t, drive_parts> numbers{shader::buffer_bone, shader::buffer_muscle,
                                                           shader::buffer_force, shader::buffer_collider,
                                                           shader::buffer_decay};
  for (const bool swapped : {false, true}) {
    BufferTable table = buffers_->table(swapped);
    for (std::size_t p = 0; p < numbers.size(); ++p)
      table[numbers[p]] = {drive_.get(), sections_[p].offset, sections_[p].bytes};
    for (std::uint32_t k = 0; k < stage_kernel_count; ++k)
      sets_[2 * k + (swapped ? 1 : 0)] =
          descriptors_->make_set((*kernels_)[static_cast<StageKernel>(k)], table);
  }
  are_sets_valid_ = true;
}

void FrameSlot::record_upload(CommandBuffer& commands) const {
  commands.copy(upload_, 0, drive_, 0, drive_bytes_);
}

void FrameSlot::record_readback(CommandBuffer& commands, bool swapped) const {
  VkDeviceSize at = 0;
  const auto copy = [&](bool wanted, std::uint32_t number, VkDeviceSize bytes) {
    if (!wanted || bytes == 0) return;
    commands.copy((*buffers_)[number], 0, readback_, at, bytes);
    at += bytes;
  };
  copy(what_.positions, shader::buffer_position, vertex_bytes_);
  copy(what_.velocities, shader::buffer_velocity, vertex_bytes_);
  copy(what_.surface, shader::buffer_surface, surface_bytes_);
  copy(what_.skinned, swapped ? shader::buffer_skinned_before : shader::buffer_skinned, vertex_bytes_);
  commands.barrier_to_host();
}

model::Frame FrameSlot::finish(SubmissionPace& pace) {
  fence.wait();
  for (std::uint32_t s = 0; s < slices_of_submission.size(); ++s)
    if (const std::optional<double> elapsed = timestamps.elapsed(s))
      pace.learn(slices_of_submission[s], *elapsed);

  model::Frame frame;
  frame.index = index;
  frame.origin = origin;
  std::size_t at = 0;
  const auto take = [&](VkDeviceSize bytes) {
    const auto part = floats(readback_.host().subspan(at, static_cast<std::size_t>(bytes)));
    at += static_cast<std::size_t>(bytes);
    return part;
  };
  if (what_.positions) narrow(take(vertex_bytes_), frame.positions);
  if (what_.velocities) narrow(take(vertex_bytes_), frame.velocities);
  if (what_.surface) {
    const std::span<const float> surface = take(surface_bytes_);
    frame.surface.assign(surface.begin(), surface.end());
  }
  if (what_.skinned) narrow(take(vertex_bytes_), frame.skinned);
  return frame;
}

}  // namespace fascicle::gpu
