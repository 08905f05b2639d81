#include "host/pipeline/device_choice.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <fstream>
#include <thread>
#include <utility>

#include "cpu_reference/solver/cpu_solver.h"
#include "gpu/vulkan_solver.h"
#include "host/base/version.h"
#include "host/build/cache.h"

namespace fascicle::pipeline {
namespace {

using cpu_reference::Simd;

constexpr const char* known_devices =
    "use auto, cpu, cpu:LEVEL, vulkan or vulkan:N (fascicle devices lists them)";

std::string yes_no(bool value) {
  return value ? "yes" : "no";
}

std::string levels_text(const std::vector<Simd>& levels) {
  std::string text;
  for (const Simd level : levels)
    text += (text.empty() ? "" : ", ") + std::string(cpu_reference::name_of(level));
  return text;
}

// Another version of the solver has other shaders, which would only add to the cached ones.
std::string key_of_pipelines(const gpu::DeviceInfo& info) {
  char digits[16];
  std::snprintf(digits, sizeof digits, "%08x", static_cast<unsigned>(base::solver_version));
  return info.pipelines_key + digits;
}

}  // namespace

DeviceRequest parse_device(const std::string& text) {
  if (text == "auto") return {.kind = DeviceRequest::Kind::automatic};
  if (text == "cpu") return {.kind = DeviceRequest::Kind::cpu};
  if (text == "vulkan") return {.kind = DeviceRequest::Kind::vulkan};
  const std::string level_prefix = "cpu:";
  if (text.starts_with(level_prefix)) {
    const auto level = cpu_reference::simd_named(text.substr(level_prefix.size()));
    if (level && *level != Simd::automatic) return {.kind = DeviceRequest::Kind::cpu, .simd = *level};
    throw UsageError("device \"" + text + "\" is unknown; after cpu: give one of " +
                     levels_text({Simd::scalar, Simd::baseline, Simd::sse4, Simd::avx2, Simd::avx512}));
  }
  const std::string prefix = "vulkan:";
  if (text.starts_with(prefix)) {
    std::uint32_t index = 0;
    const char* last = text.data() + text.size();
    const auto [end, error] = std::from_chars(text.data() + prefix.size(), last, index);
    if (error == std::errc() && end == last) return {.kind = DeviceRequest::Kind::vulkan, .index = index};
  }
  throw UsageError("device \"" + text + "\" is unknown; " + known_devices);
}

std::vector<std::string> split_device_list(const std::string& text) {
  std::vector<std::string> entries;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t comma = std::min(text.find(',', begin), text.size());
    entries.push_back(text.substr(begin, comma - begin));
    begin = comma + 1;
  }
  return entries;
}

std::vector<DeviceRequest> parse_device_list(const std::string& text) {
  std::vector<DeviceRequest> requests;
  for (const std::string& entry : split_device_list(text)) {
    requests.push_back(parse_device(entry));
    if (requests.back().kind == DeviceRequest::Kind::automatic)
      throw UsageError("in a list of devices, use cpu, cpu:LEVEL, vulkan or vulkan:N, not auto");
  }
  return requests;
}

std::vector<gpu::DeviceInfo> devices_for(const std::string& list) {
  const std::vector<std::string> entries = split_device_list(list);
  const auto is_cpu = [](const std::string& entry) { return entry == "cpu" || entry.starts_with("cpu:"); };
  return std::all_of(entries.begin(), entries.end(), is_cpu) ? std::vector<gpu::DeviceInfo>()
                                                             : gpu::list_devices();
}

std::string with_all_devices(const std::string& list, std::span<const gpu::DeviceInfo> devices) {
  std::string text;
  const auto add = [&text](const std::string& entry) { text += (text.empty() ? "" : ",") + entry; };
  for (const std::string& entry : split_device_list(list)) {
    if (entry != "all") {
      add(entry);
      continue;
    }
    for (const gpu::DeviceInfo& device : candidates({}, devices))
      add("vulkan:" + std::to_string(device.index));
    add("cpu");
  }
  return text;
}

std::vector<DeviceRequest> parse_device_order(const std::string& text) {
  std::vector<DeviceRequest> requests;
  const bool asks_for_all = text.find("all") != std::string::npos;
  const std::string list = asks_for_all ? with_all_devices(text, devices_for(text)) : text;
  for (const std::string& entry : split_device_list(list)) requests.push_back(parse_device(entry));
  if (requests.back().kind == DeviceRequest::Kind::automatic)
    requests.push_back({.kind = DeviceRequest::Kind::cpu});
  return requests;
}

std::vector<gpu::DeviceInfo> candidates(const DeviceRequest& request,
                                        std::span<const gpu::DeviceInfo> devices) {
  std::vector<gpu::DeviceInfo> found;
  if (request.kind == DeviceRequest::Kind::cpu) return found;
  if (request.index) {
    for (const gpu::DeviceInfo& device : devices)
      if (device.index == *request.index) found.push_back(device);
    return found;
  }
  for (const gpu::DeviceInfo& device : devices)
    if (device.usable && !device.software) found.push_back(device);
  const auto rank = [](const gpu::DeviceInfo& device) {
    return device.type == "discrete" ? 0 : device.type == "integrated" ? 2 : 1;
  };
  std::stable_sort(found.begin(), found.end(), [&](const gpu::DeviceInfo& a, const gpu::DeviceInfo& b) {
    return rank(a) != rank(b) ? rank(a) < rank(b) : a.memory > b.memory;
  });
  if (request.kind == DeviceRequest::Kind::vulkan)
    for (const gpu::DeviceInfo& device : devices)
      if (device.usable && device.software) found.push_back(device);
  return found;
}

ChosenDevice ChosenDevice::cpu(unsigned threads, Simd simd, std::string why) {
  const std::vector<Simd> here = cpu_reference::available_simd();
  if (simd != Simd::automatic && std::find(here.begin(), here.end(), simd) == here.end())
    throw NoSuchDevice("this CPU (" + processor_name() + ") has no " + cpu_reference::name_of(simd) +
                       " instructions; it has " + levels_text(here));
  ChosenDevice chosen;
  chosen.label_ = simd == Simd::automatic ? "cpu" : std::string("cpu:") + cpu_reference::name_of(simd);
  chosen.simd_ = simd == Simd::automatic ? here.back() : simd;
  chosen.why_ = std::move(why);
  chosen.description_.solver = "cpu";
  chosen.description_.name = processor_name();
#if defined(__clang__)
  chosen.description_.driver = "compiled by Clang " __clang_version__;
#else
  chosen.description_.driver = "compiled by GCC " __VERSION__;
#endif
  chosen.description_.float_controls = "IEEE 754 binary32, rounding to nearest even, no contraction";
  chosen.description_.exact = true;
  chosen.description_.threads = threads == 0 ? processor_threads() : threads;
  return chosen;
}

ChosenDevice ChosenDevice::vulkan(const gpu::DeviceInfo& info, const DeviceRequest& request,
                                  std::string why) {
  ChosenDevice chosen;
  chosen.label_ = "vulkan:" + std::to_string(info.index);
  chosen.why_ = std::move(why);
  chosen.keeps_pipelines_ = request.keeps_pipelines;
  chosen.cache_ = request.cache.empty() ? build::default_cache_folder() : request.cache;
  gpu::DeviceOptions options;
  if (request.keeps_pipelines)
    options.pipelines = build::Cache(chosen.cache_).find(key_of_pipelines(info)).value_or(std::string());
  chosen.device_ = std::make_unique<gpu::Device>(info.index, options);
  chosen.description_.solver = "vulkan";
  chosen.description_.name = info.name;
  chosen.description_.driver = info.driver;
  chosen.description_.float_controls = float_controls_text(info);
  chosen.description_.exact = chosen.device_->self_test(&chosen.why_not_exact_);
  if (chosen.description_.exact) chosen.why_not_exact_.clear();
  return chosen;
}

std::string ChosenDevice::text() const {
  std::string text = label_ + ", " + description_.name;
  if (description_.threads > 0)
    text +=
        ", " + std::to_string(description_.threads) + (description_.threads == 1 ? " thread" : " threads");
  text += ", " + (device_ ? description_.driver : cpu_reference::name_of(simd_));
  if (!description_.exact) text += ", not exact (" + why_not_exact_ + ")";
  if (!why_.empty()) text += " (" + why_ + ")";
  return text;
}

std::string ChosenDevice::pipelines() const {
  if (!keeps_pipelines_) return {};
  try {
    return device_->pipelines();
  } catch (const gpu::DeviceError&) {
    return {};  // if it cannot be cached, it is compiled again
  }
}

std::unique_ptr<model::Solver> ChosenDevice::make_solver(const model::Model& model,
                                                         const model::SolverOptions& options,
                                                         SolverMemory* memory) const {
  if (!device_) return cpu_reference::make_cpu_solver(model, options, description_.threads, simd_, memory);
  try {
    const std::string before = pipelines();
    std::unique_ptr<model::Solver> solver = gpu::make_vulkan_solver(*device_, model, options);
    if (const std::string after = pipelines(); !after.empty() && after != before)
      build::Cache(cache_).put(key_of_pipelines(device_->info()), after);
    return solver;
  } catch (const gpu::DeviceLost&) {
    throw;
  } catch (const gpu::DeviceError& error) {
    throw NoSuchDevice(label_ + " (" + description_.name + ") cannot run this scene: " + error.what() +
                       "; use --device cpu or a coarser mesh");
  }
}

ChosenDevice choose_device(const DeviceRequest& request, unsigned threads, const Say& say) {
  if (request.kind == DeviceRequest::Kind::cpu) return ChosenDevice::cpu(threads, request.simd, "");
  const bool automatic = request.kind == DeviceRequest::Kind::automatic;

  std::string why_none;
  const std::vector<gpu::DeviceInfo> devices = gpu::list_devices(&why_none);
  const std::vector<gpu::DeviceInfo> order = candidates(request, devices);
  std::string refusal;
  for (const gpu::DeviceInfo& info : order) {
    const std::string label = "vulkan:" + std::to_string(info.index) + " (" + info.name + ")";
    if (!info.usable) throw NoSuchDevice(label + " cannot be used: " + info.why_not + "; " + known_devices);
    try {
      std::string why;
      if (automatic)
        why = "auto: a GPU that passes the self-test";
      else if (!request.index)
        why = info.software ? "no real GPU; the first software device" : "the best real GPU";
      ChosenDevice chosen = ChosenDevice::vulkan(info, request, why);
      if (!automatic || chosen.description().exact) return chosen;
      refusal = label + " is not exact: " + chosen.why_not_exact();
    } catch (const gpu::DeviceError& error) {
      refusal = label + ": " + error.what();
      if (request.index) throw NoSuchDevice(refusal);
    }
    say_warning(say, refusal);
  }
  if (automatic)
    return ChosenDevice::cpu(
        threads, Simd::automatic,
        refusal.empty() ? "auto: no real GPU" : "auto: no GPU can run this scene exactly");
  if (request.index && !devices.empty())
    throw NoSuchDevice("there is no device vulkan:" + std::to_string(*request.index) + ", only " +
                       std::to_string(devices.size()) + " (0 to " + std::to_string(devices.size() - 1) +
                       "); " + known_devices);
  if (!refusal.empty()) throw NoSuchDevice(refusal);
  throw NoSuchDevice(
      "there is no Vulkan device" + (why_none.empty() ? std::string() : ": " + why_none) +
      "; use --device cpu, or install a driver (Mesa's lavapipe needs no GPU: mesa-vulkan-drivers)");
}

Simulation choose_simulation(const DeviceRequest& request, unsigned threads, const model::Model& model,
                             const model::SolverOptions& options, const Say& say) {
  ChosenDevice device = choose_device(request, threads, say);
  std::unique_ptr<model::Solver> solver;
  try {
    solver = device.make_solver(model, options);
  } catch (const gpu::DeviceLost& error) {
    if (request.kind != DeviceRequest::Kind::automatic) throw;
    say_warning(say, device.label() + ": " + error.what());
    device = ChosenDevice::cpu(threads, Simd::automatic, "auto: the GPU was lost");
    solver = device.make_solver(model, options);
  } catch (const NoSuchDevice& error) {
    if (request.kind != DeviceRequest::Kind::automatic) throw;
    say_warning(say, error.what());
    device = ChosenDevice::cpu(threads, Simd::automatic, "auto: the scene does not fit the GPU");
    solver = device.make_solver(model, options);
  }
  say_info(say, "device: " + device.text());
  return {std::move(device), std::move(solver)};
}

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("model name")) continue;
    const std::size_t colon = line.find(": ");
    if (colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown processor";
}

unsigned processor_threads() {
  const unsigned count = std::thread::hardware_concurrency();
  return count == 0 ? 1 : count;
}

std::string float_controls_text(const gpu::DeviceInfo& info) {
  return "rounding to nearest even: " + yes_no(info.rounding_rte) +
         ", signed zero, infinity and NaN kept: " + yes_no(info.signed_zero_inf_nan_preserve) +
         ", denormals kept: " + yes_no(info.denorm_preserve);
}

}  // namespace fascicle::pipeline
