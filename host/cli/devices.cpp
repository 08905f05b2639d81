// fascicle devices: lists the devices, and whether their arithmetic is exact.
#include <iostream>
#include <memory>

#include <nlohmann/json.hpp>

#include "gpu/device.h"
#include "host/cli/command.h"
#include "host/cli/text.h"
#include "host/pipeline/device_choice.h"

namespace fascicle::cli {
namespace {

struct Examined {
  gpu::DeviceInfo info;
  bool exact = false;
  std::string why_not;  // why it is inexact or unusable
};

Examined examine(const gpu::DeviceInfo& info) {
  Examined examined{info, false, info.why_not};
  if (!info.usable) return examined;
  try {
    gpu::Device device(info.index);
    examined.exact = device.self_test(&examined.why_not);
    if (examined.exact) examined.why_not.clear();
  } catch (const gpu::DeviceError& error) {
    examined.info.usable = false;
    examined.why_not = error.what();
  }
  return examined;
}

std::string self_test_text(const Examined& device) {
  if (!device.info.usable) return "not run: not usable: " + device.why_not;
  return device.exact ? "exact" : "not exact: " + device.why_not;
}

nlohmann::ordered_json json_of(const Examined& device) {
  const gpu::DeviceInfo& info = device.info;
  return {{"device", "vulkan:" + std::to_string(info.index)},
          {"name", info.name},
          {"type", info.type},
          {"software", info.software},
          {"driver", info.driver},
          {"api_version", info.api_version},
          {"memory_bytes", info.memory},
          {"max_storage_buffer_range", info.max_storage_buffer_range},
          {"max_groups", info.max_groups},
          {"subgroup_size", info.subgroup_size},
          {"float_controls",
           {{"rounding_rte", info.rounding_rte},
            {"signed_zero_inf_nan_preserve", info.signed_zero_inf_nan_preserve},
            {"denorm_preserve", info.denorm_preserve}}},
          {"usable", info.usable},
          {"exact", device.exact},
          {"why_not", device.why_not}};
}

void print_text(const Examined& device) {
  const gpu::DeviceInfo& info = device.info;
  std::cout << "vulkan:" << info.index << "  " << info.name << "\n"
            << columns_text({{"type", info.type + (info.software ? " (software)" : "")},
                             {"driver", info.driver},
                             {"Vulkan", info.api_version},
                             {"memory", bytes_text(info.memory)},
                             {"largest storage buffer", bytes_text(info.max_storage_buffer_range)},
                             {"workgroups", count_text(info.max_groups)},
                             {"subgroup size", std::to_string(info.subgroup_size)},
                             {"float controls", float_controls_text(info)},
                             {"self-test", self_test_text(device)}});
}

ExitCode devices(bool json) {
  std::string why_none;
  std::vector<Examined> examined;
  for (const gpu::DeviceInfo& info : gpu::list_devices(&why_none)) examined.push_back(examine(info));

  std::vector<std::string> levels;
  for (const cpu_reference::Simd level : cpu_reference::available_simd()) levels.push_back(name_of(level));
  if (json) {
    nlohmann::ordered_json object{{"cpu",
                                   {{"device", "cpu"},
                                    {"name", processor_name()},
                                    {"threads", processor_threads()},
                                    {"levels", levels}}},
                                  {"vulkan", nlohmann::ordered_json::array()}};
    for (const Examined& device : examined) object["vulkan"].push_back(json_of(device));
    if (examined.empty()) object["why_no_vulkan"] = why_none;
    std::cout << object.dump(2) << "\n";
    return ExitCode::done;
  }
  std::string joined;
  for (const std::string& level : levels) joined += (joined.empty() ? "" : ", ") + level;
  std::cout << "cpu  " << processor_name() << "\n"
            << columns_text({{"threads", std::to_string(processor_threads())},
                             {"levels", joined},
                             {"arithmetic", "exact (the reference)"}});
  for (const Examined& device : examined) print_text(device);
  if (examined.empty()) std::cout << "no Vulkan device" << (why_none.empty() ? "" : ": " + why_none) << "\n";
  return ExitCode::done;
}

}  // namespace

void add_devices(CLI::App& app, Command& command) {
  auto* subcommand = app.add_subcommand("devices", "List the CPU and every Vulkan device, and test them");
  const auto json = std::make_shared<bool>(false);
  subcommand->add_flag("--json", *json, "Print one JSON object");
  add_log_options(*subcommand, command.log);
  subcommand->callback([json, &command] { command.run = [json](Log&) { return devices(*json); }; });
}

}  // namespace fascicle::cli
