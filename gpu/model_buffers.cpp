#include "gpu/model_buffers.h"

#include <type_traits>

#include "gpu/sliced_rings.h"
#include "host/model/model_arrays.h"
#include "host/model/substep_plan.h"

namespace fascicle::gpu {
namespace {

using model::Model;

// x y z of `triples`, followed by one more number.
std::vector<float> records(const std::vector<float>& triples, const std::vector<float>& fourth) {
  std::vector<float> out(triples.size() / 3 * 4);
  for (std::size_t i = 0; i < triples.size() / 3; ++i) {
    for (std::size_t c = 0; c < 3; ++c) out[4 * i + c] = triples[3 * i + c];
    out[4 * i + 3] = fourth.empty() ? 0.0f : fourth[i];
  }
  return out;
}

std::vector<std::uint32_t> tags_and_degrees(const Model& model) {
  std::vector<std::uint32_t> out(model.vertex_count);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    const std::uint32_t degree = model.ring_offset[i + 1] - model.ring_offset[i];
    if (degree >= 1u << (32 - shader::degree_shift))
      throw DeviceError(
          "vertex " + std::to_string(i) + " of the model has " + std::to_string(degree) +
          " neighbours, more than the 65535 of the GPU layout; use --device cpu, or a better mesh");
    out[i] = model.tag[i] | degree << shader::degree_shift;
  }
  return out;
}

}  // namespace

std::vector<PlannedBuffer> plan_buffers(const Model& model) {
  const std::uint64_t n = model.vertex_count;
  const std::uint64_t entries = sliced_entry_count(model);
  std::vector<PlannedBuffer> plan;
  for (const model::FieldTraits& row : model::field_rows) {
    const bool is_kept = row.is_kept == nullptr || (model.*row.is_kept)();
    plan.push_back(
        {row.buffer, row.name, is_kept ? std::uint64_t{row.bytes} * item_count(model, row.items) : 0});
  }
  plan.insert(
      plan.end(),
      {
          {shader::buffer_response, "response", model.is_implicit() ? 2 * sizeof(shader::Response) * n : 0},
          // Buffers that combine several arrays of the model.
          {shader::buffer_rest, "rest", 16 * n},
          {shader::buffer_tag, "tag", 4 * n},
          {shader::buffer_slice, "slice", 4 * ((n + shader::slice_width - 1) / shader::slice_width)},
          {shader::buffer_ring, "ring", is_near(model) ? 0 : 4 * entries},
          {shader::buffer_share_taken, "share taken", 4 * entries},
          {shader::buffer_share_given, "share given", 4 * entries},
      });
  model::for_each_array(model, [&](const auto& row, const auto& values) {
    const model::Buffer& buffer = row.traits.buffer;
    if (buffer.number == model::no_buffer) return;
    const std::uint64_t items = buffer.as_vec4 ? values.size() / 3 * 4 : values.size();
    plan.push_back({buffer.number, row.name, items * sizeof(values[0])});
  });
  return plan;
}

void check_plan(const std::vector<PlannedBuffer>& plan, std::uint64_t frames_in_flight_bytes,
                const DeviceInfo& device) {
  std::uint64_t total = frames_in_flight_bytes;
  for (const PlannedBuffer& buffer : plan) {
    total += buffer.bytes;
    if (buffer.bytes > device.max_storage_buffer_range)
      throw DeviceError("the model's buffer \"" + std::string(buffer.name) + "\" needs " +
                        std::to_string(buffer.bytes) + " bytes, but device " + device.name +
                        " binds at most " + std::to_string(device.max_storage_buffer_range) +
                        " (maxStorageBufferRange); use a coarser mesh or another device");
  }
  if (total > device.memory)
    throw DeviceError("the model needs " + std::to_string(total) + " bytes (" +
                      std::to_string(frames_in_flight_bytes) + " of them for frames in flight), device " +
                      device.name + " has " + std::to_string(device.memory) +
                      "; use a coarser mesh or another device");
}

ModelBuffers::ModelBuffers(Device::Impl& device, const Model& model) {
  for (const PlannedBuffer& planned : plan_buffers(model))
    buffers_[planned.number] = Buffer(device, planned.bytes, BufferUse::storage);
  const auto fill = [&](std::uint32_t number, const auto& values) {
    write_buffer(device, buffers_[number], std::as_bytes(std::span(values)));
  };
  fill(shader::buffer_rest, records(model.rest, model.pull));
  fill(shader::buffer_tag, tags_and_degrees(model));
  {
    const SlicedRings rings = slice_rings(model);
    fill(shader::buffer_slice, rings.slice);
    fill(shader::buffer_ring, rings.ring);
    fill(shader::buffer_share_taken, rings.share_taken);
    fill(shader::buffer_share_given, rings.share_given);
  }
  model::for_each_array(model, [&](const auto& row, const auto& values) {
    const model::Buffer& buffer = row.traits.buffer;
    if (buffer.number == model::no_buffer) return;
    if constexpr (std::is_same_v<std::decay_t<decltype(values)>, std::vector<float>>)
      if (buffer.as_vec4) return fill(buffer.number, widened(values));
    fill(buffer.number, values);
  });
}

BufferTable ModelBuffers::table(bool swapped) const {
  BufferTable table{};
  for (std::uint32_t number = 0; number < shader::buffer_count; ++number)
    if (buffers_[number].get() != VK_NULL_HANDLE) table[number] = whole(buffers_[number]);
  if (swapped) std::swap(table[shader::buffer_skinned], table[shader::buffer_skinned_before]);
  return table;
}

std::vector<float> widened(const std::vector<float>& triples) {
  return records(triples, {});
}

void narrow(std::span<const float> records_in, std::vector<float>& triples) {
  triples.resize(records_in.size() / 4 * 3);
  for (std::size_t i = 0; i < records_in.size() / 4; ++i)
    for (std::size_t c = 0; c < 3; ++c) triples[3 * i + c] = records_in[4 * i + c];
}

}  // namespace fascicle::gpu
