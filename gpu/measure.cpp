#include "gpu/measure.h"

#include <algorithm>
#include <array>
#include <chrono>

#include "gpu/device_impl.h"
#include "gpu/frame_slot.h"
#include "gpu/sliced_rings.h"
#include "host/model/implicit.h"
#include "shaders/modules.h"

namespace fascicle::gpu {
namespace {

// Seconds that `repeats` times the commands of `record` take, by the device's clock, or by the host's if it
// has none.
template <class Record>
double seconds_of(Device::Impl& device, int repeats, const Record& record) {
  const CommandPool pool(device);
  const Timestamps timestamps(device, 1);
  CommandBuffer commands(device, pool);
  commands.barrier();
  commands.begin_timing(timestamps, 0);
  for (int k = 0; k < repeats; ++k) {
    record(commands);
  }
  commands.end_timing(timestamps, 0);
  const auto start = std::chrono::steady_clock::now();
  commands.submit_and_wait();
  const std::chrono::duration<double> waited = std::chrono::steady_clock::now() - start;
  return timestamps.elapsed(0).value_or(waited.count() * 1e9) * 1e-9;
}

// The kernels of the plan, except skin, tie and those of stage limit.
std::vector<StageKernel> stages_of(const model::Model& model, const model::SolverOptions& options) {
  model::SubstepPlan plan = substep_plan(model, options, false);
  std::erase_if(plan, [](const model::Block& b) { return b.repeat == model::Block::Repeat::limit_passes; });
  std::vector<StageKernel> kernels = kernels_of(plan);
  std::erase_if(kernels, [](StageKernel k) { return k == StageKernel::skin || k == StageKernel::tie; });
  return kernels;
}

}  // namespace

double copy_rate(Device& opened) {
  Device::Impl& device = opened.impl();
  // Several times the size of caches in real devices.
  const VkDeviceSize bytes = std::min({VkDeviceSize{device.info().software ? 64u : 512u} << 20,
                                       VkDeviceSize{device.info().memory / 8},
                                       VkDeviceSize{device.info().max_storage_buffer_range}}) /
                             16 * 16;
  constexpr std::uint32_t group = 128, item_bytes = 16;  // every device supports workgroups of 128
  std::array<std::uint32_t, shader::constant_count> constants{};
  constants[shader::constant_group_size] = group;
  const Kernel kernel(device, shader::module_of("copy"), constants, device.float_controls());
  const Buffer from(device, bytes, BufferUse::storage), to(device, bytes, BufferUse::storage);
  BufferTable buffers{};
  buffers[shader::buffer_position] = whole(from);
  buffers[shader::buffer_velocity] = whole(to);
  DescriptorPool sets(device, 1);
  const VkDescriptorSet set = sets.make_set(kernel, buffers);
  shader::Push push{};
  push.substep.vertex_count = static_cast<std::uint32_t>(bytes / item_bytes);
  const std::uint32_t groups =
      std::min((push.substep.vertex_count + group - 1) / group, device.info().max_groups);
  // A device's copy engine may be faster or slower than its shaders' loads and stores.
  double best = 0.0;
  for (int round = 0; round < 5; ++round) {
    constexpr int copies = 4;
    const double own = seconds_of(device, copies, [&](CommandBuffer& commands) {
      commands.copy(from, 0, to, 0, bytes);
      commands.barrier();
    });
    const double by_shader = seconds_of(device, copies, [&](CommandBuffer& commands) {
      commands.dispatch(kernel, set, push, groups);
      commands.barrier();
    });
    const double moved = 2.0 * copies * static_cast<double>(bytes);
    const double reached =
        static_cast<double>(std::min<std::uint64_t>(bytes, std::uint64_t{groups} * group * item_bytes));
    best = std::max({best, moved / own, 2.0 * copies * reached / by_shader});
  }
  return best;
}

std::vector<StageTime> stage_times(Device& opened, const model::Model& model,
                                   const model::SolverOptions& options, const model::Drive& drive) {
  Device::Impl& device = opened.impl();
  if (!device.physical.has_timestamps) return {};
  const StageKernels kernels(device, model, options, device.float_controls(), tuning_for(device.info()), {});
  ModelBuffers buffers(device, model);
  shader::Push push{};
  push.substep = model::first_substep(model, drive);
  const model::State rest = model::rest_state(model);
  const auto write = [&](std::uint32_t number, const std::vector<float>& values) {
    write_buffer(device, buffers[number], std::as_bytes(std::span(values)));
  };
  write(shader::buffer_position, widened(rest.positions));
  write(shader::buffer_velocity, widened(rest.velocities));
  write(shader::buffer_rotation, rest.rotations);
  if (model.is_implicit()) {
    const model::ImplicitTables tables = model::implicit_tables(model, options, drive.h);
    push.implicit = model::implicit_step(model, tables, false);
    push.implicit.omega = push.implicit.gain = 1.0f;
    write_buffer(device, buffers[shader::buffer_response], std::as_bytes(std::span(tables.responses)));
    write(shader::buffer_position_before, widened(rest.positions));
    write(shader::buffer_velocity_before, widened(rest.velocities));
  }
  FrameSlot slot(device, kernels, buffers);
  slot.prepare(drive, {}, 0, 0);
  {
    const CommandPool pool(device);
    CommandBuffer commands(device, pool);
    slot.record_upload(commands);
    commands.submit_and_wait();
  }
  const std::uint32_t group = kernels.slices_per_group() * shader::slice_width;
  const std::uint32_t groups = model.vertex_count / group + (model.vertex_count % group != 0 ? 1 : 0);
  if (groups > device.info().max_groups) return {};
  std::vector<StageTime> times;
  for (const StageKernel kernel : stages_of(model, options)) {
    const auto run = [&](int repeats) {
      return seconds_of(device, repeats, [&](CommandBuffer& commands) {
        commands.dispatch(kernels[kernel], slot.set(kernel, false), push, groups);
        commands.barrier();
      });
    };
    // About 20 ms, so that overhead before and after is negligible.
    const double once = run(2) / 2;
    const int repeats = static_cast<int>(std::clamp(20e-3 / std::max(once, 1e-7), 1.0, 500.0));
    times.push_back({std::string(name_of(kernel)), run(repeats) / repeats * 1e9});
  }
  return times;
}

double substep_bytes(const model::Model& model, std::uint32_t passes) {
  constexpr double vector = 16, map = 48, number = 4;
  const double slices = 1.0 / shader::slice_width;
  const double entries = static_cast<double>(sliced_entry_count(model)) / model.vertex_count;
  const double rings = slices * number + entries * (is_near(model) ? 1 : 2) * number;
  // Position, rest, centre at rest, rotation read and written, map.
  const double region = rings + number + 3 * vector + 2 * vector + map;
  const double blend = rings + number + map + vector;
  if (!model.is_implicit()) return region + blend + 4 * vector + number;
  // Goal; position and the previous iterate, both read and written; y; response.
  return passes * (region + blend + vector + 4 * vector + vector + sizeof(shader::Response));
}

}  // namespace fascicle::gpu
