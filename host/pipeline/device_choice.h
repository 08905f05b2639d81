// --device: what was requested, what is available, what is chosen. The only place that picks a solver.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cpu_reference/solver/cpu_solver.h"
#include "cpu_reference/solver/simd.h"
#include "gpu/device.h"
#include "host/bake/bake.h"
#include "host/model/solver.h"
#include "host/pipeline/errors.h"
#include "host/pipeline/messages.h"

namespace fascicle::pipeline {

struct DeviceRequest {
  enum class Kind { automatic, cpu, vulkan };
  Kind kind = Kind::automatic;
  std::optional<std::uint32_t> index = std::nullopt;          // for vulkan:N
  cpu_reference::Simd simd = cpu_reference::Simd::automatic;  // for cpu:LEVEL
  bool keeps_pipelines = true;       // reads and writes the cache of compiled shaders
  std::filesystem::path cache = {};  // its folder; empty: build::default_cache_folder()
};

// "auto", "cpu", "cpu:LEVEL" (the instructions to use, see simd.h), "vulkan", "vulkan:N". Throws UsageError.
DeviceRequest parse_device(const std::string& text);
// Splits "cpu,vulkan:1" at its commas.
std::vector<std::string> split_device_list(const std::string& text);
// For "cpu,vulkan:1". Throws UsageError, also for an empty entry and for "auto".
std::vector<DeviceRequest> parse_device_list(const std::string& text);

// The devices of a bake: the first, and those that take over in turn if one fails: "cpu", "vulkan:0,cpu".
// "auto" is followed by the CPU; "all" is every real GPU and the CPU. Throws UsageError.
std::vector<DeviceRequest> parse_device_order(const std::string& text);
// The Vulkan devices that the list may refer to. For a list of CPUs alone there are none, and Vulkan is not
// loaded.
std::vector<gpu::DeviceInfo> devices_for(const std::string& list);
// The list with "all" replaced by "vulkan:0,vulkan:1,cpu".
std::string with_all_devices(const std::string& list, std::span<const gpu::DeviceInfo> devices);

// The devices of a request in the order in which to try them. automatic: usable real GPUs, discrete ones
// first and those with more memory before others; vulkan: the same, then usable software devices; with an
// index, that device, usable or not.
std::vector<gpu::DeviceInfo> candidates(const DeviceRequest& request,
                                        std::span<const gpu::DeviceInfo> devices);

// What a solver passes on to the next one on the same device.
using cpu_reference::SolverMemory;

// A device ready to make solvers. Must outlive them.
class ChosenDevice {
 public:
  // Throws NoSuchDevice if the machine lacks the instructions.
  static ChosenDevice cpu(unsigned threads, cpu_reference::Simd simd, std::string why);
  // Opens the device and runs its self-test. Throws gpu::DeviceError.
  static ChosenDevice vulkan(const gpu::DeviceInfo& info, const DeviceRequest& request, std::string why);

  // "cpu", "cpu:LEVEL" or "vulkan:N"
  const std::string& label() const { return label_; }
  // One line for users: label, name, driver, exact or not, why it was chosen.
  std::string text() const;
  const bake::DeviceDescription& description() const { return description_; }
  // First difference that the self-test found; empty if exact.
  const std::string& why_not_exact() const { return why_not_exact_; }
  // `memory` may be null. Throws NoSuchDevice if the model does not fit the device.
  std::unique_ptr<model::Solver> make_solver(const model::Model& model, const model::SolverOptions& options,
                                             SolverMemory* memory = nullptr) const;
  // The Vulkan device; null: the CPU.
  gpu::Device* gpu() const { return device_.get(); }

 private:
  // Compiled pipelines worth caching; empty if nothing is cached.
  std::string pipelines() const;

  std::string label_, why_, why_not_exact_;
  bake::DeviceDescription description_;
  cpu_reference::Simd simd_ = cpu_reference::Simd::automatic;
  std::unique_ptr<gpu::Device> device_;  // null: the CPU
  bool keeps_pipelines_ = false;
  std::filesystem::path cache_;
};

// Chooses a device. automatic: the best real GPU that passes its self-test, else the CPU. Throws
// NoSuchDevice. `threads` 0: one per core.
ChosenDevice choose_device(const DeviceRequest& request, unsigned threads, const Say& say);

// The same with a solver for one model, so that automatic can fall back to the CPU if the model does not fit
// the GPU. Reports the choice.
struct Simulation {
  ChosenDevice device;
  std::unique_ptr<model::Solver> solver;
};
Simulation choose_simulation(const DeviceRequest& request, unsigned threads, const model::Model& model,
                             const model::SolverOptions& options, const Say& say);

// The processor's model name and number of cores.
std::string processor_name();
unsigned processor_threads();
// "rounding to nearest even: yes, signed zero, infinity and NaN kept: yes, denormals kept: no"
std::string float_controls_text(const gpu::DeviceInfo& info);

}  // namespace fascicle::pipeline
