#include "host/cli/bake_devices.h"

#include <algorithm>
#include <cstddef>
#include <thread>
#include <utility>

#include "cpu_reference/solver/simd.h"
#include "gpu/device.h"
#include "host/pipeline/device_choice.h"
#include "host/pipeline/errors.h"

namespace fascicle::cli {

namespace {

// For most of a bake, a GPU waits for the threads that feed it, so several bakes share one. A software driver
// uses all cores for a single bake.
constexpr unsigned most_on_a_gpu = 8;

}  // namespace

void require_devices(const std::string& list) {
  const std::vector<gpu::DeviceInfo> devices = devices_for(list);
  const std::vector<std::string> labels = split_device_list(list);
  for (const std::string& label : labels) {
    const DeviceRequest request = parse_device(label);
    if (request.kind == DeviceRequest::Kind::automatic) continue;
    const std::vector<cpu_reference::Simd> levels = cpu_reference::available_simd();
    const cpu_reference::Simd simd = request.simd;
    const bool is_there = request.kind == DeviceRequest::Kind::cpu
                              ? simd == cpu_reference::Simd::automatic ||
                                    std::find(levels.begin(), levels.end(), simd) != levels.end()
                              : !candidates(request, devices).empty();
    if (!is_there) throw NoSuchDevice(label + ": there is no such device; fascicle devices lists them");
  }
}

std::vector<BakeDevice> devices_at_once(const ManyBakes& asked) {
  const std::vector<std::string> labels = split_device_list(asked.devices);
  const auto is_cpu = [](const std::string& label) {
    return parse_device(label).kind == DeviceRequest::Kind::cpu;
  };
  const auto on_cpu = static_cast<unsigned>(std::count_if(labels.begin(), labels.end(), is_cpu));
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency() / std::max(1U, on_cpu));
  const std::vector<gpu::DeviceInfo> gpus = devices_for(asked.devices);
  std::vector<std::pair<BakeDevice, std::size_t>> devices;
  std::size_t most = 0;
  for (const std::string& label : labels) {
    BakeDevice device{label, asked.threads};
    unsigned at_once = std::max(1U, cores / std::max(1U, asked.threads));
    if (!is_cpu(label)) {
      const std::vector<gpu::DeviceInfo> found = candidates(parse_device(label), gpus);
      const bool is_real = !found.empty() && !found.front().software;
      at_once = is_real ? std::clamp(cores / 2, 1U, most_on_a_gpu) : 1U;
      device.memory = is_real ? found.front().memory : 0;
    }
    if (asked.at_once > 0) at_once = asked.at_once;
    const std::size_t bakes = std::min<std::size_t>(at_once, asked.bakes.size());
    if (device.threads == 0 && is_cpu(label) && bakes > 1)
      device.threads = std::max(1U, cores / static_cast<unsigned>(bakes));
    devices.emplace_back(std::move(device), bakes);
    most = std::max(most, bakes);
  }
  std::vector<BakeDevice> interleaved;
  for (std::size_t turn = 0; turn < most; ++turn)
    for (const auto& [device, bakes] : devices)
      if (turn < bakes) interleaved.push_back(device);
  return interleaved;
}

}  // namespace fascicle::cli
