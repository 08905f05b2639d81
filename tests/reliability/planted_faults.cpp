// planted_faults core|synchronization|gpu: makes one invalid use of Vulkan through the solver's own classes.
// A control: the validation layer must report it.
// planted_faults layer: opens a device with the validation layer, as tests do. Exits with 4 and a reason if
// it cannot.
#include <algorithm>
#include <array>
#include <cstdio>
#include <string>

#include "gpu/command.h"
#include "gpu/descriptor.h"
#include "gpu/device.h"
#include "gpu/kernel.h"
#include "shaders/modules.h"

namespace {

using namespace fascicle;
using namespace fascicle::gpu;

constexpr VkDeviceSize bytes = 1024;

// Reads past the end of a buffer, by a copy whose size the host knows.
void plant_core(CommandBuffer& commands, const Buffer& from, const Buffer& to) {
  commands.copy(from, 0, to, 0, 2 * bytes);
}

// Two copies to the same place without a barrier between them.
void plant_hazard(CommandBuffer& commands, const Buffer& from, const Buffer& to) {
  commands.copy(from, 0, to, 0, bytes);
  commands.copy(from, 0, to, 0, bytes);
}

// Reads past the end of a buffer, in a shader.
void plant_on_device(Device::Impl& device, const Buffer& from, const Buffer& to) {
  constexpr std::uint32_t group = 128;
  std::array<std::uint32_t, shader::constant_count> constants{};
  constants[shader::constant_group_size] = group;
  const Kernel kernel(device, shader::module_of("copy"), constants, device.float_controls());
  BufferTable buffers{};
  buffers[shader::buffer_position] = whole(from);
  buffers[shader::buffer_velocity] = whole(to);
  DescriptorPool sets(device, 1);
  shader::Push push{};
  push.substep.vertex_count = group;  // twice as many as there are
  const CommandPool pool(device);
  CommandBuffer commands(device, pool);
  commands.dispatch(kernel, sets.make_set(kernel, buffers), push, 1);
  commands.submit_and_wait();
}

}  // namespace

int main(int count, char** arguments) {
  const std::string fault = count > 1 ? arguments[1] : "";
  const auto devices = list_devices();
  const auto usable = std::find_if(devices.begin(), devices.end(), [](const auto& d) { return d.usable; });
  if (usable == devices.end()) return std::fprintf(stderr, "no Vulkan device\n"), 4;
  if (fault == "layer") {
    try {
      return Device(usable->index, {.validation = true}), 0;
    } catch (const DeviceError& error) {
      return std::fprintf(stderr, "planted_faults: error: %s\n", error.what()), 4;
    }
  }
  Device opened(usable->index);
  Device::Impl& device = opened.impl();
  const Buffer from(device, bytes, BufferUse::storage), to(device, bytes, BufferUse::storage);
  if (fault == "gpu") return plant_on_device(device, from, to), 0;
  // Recorded but never submitted, so that no driver has to survive it.
  const CommandPool pool(device);
  CommandBuffer commands(device, pool);
  if (fault == "core") return plant_core(commands, from, to), 0;
  if (fault == "synchronization") return plant_hazard(commands, from, to), 0;
  return std::fprintf(stderr, "planted_faults core|synchronization|gpu|layer\n"), 2;
}
