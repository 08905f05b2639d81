// Vulkan instance and devices. volk loads Vulkan at run time, so the program starts without it. Use: choose
// from list_devices, open a Device by its index, run self_test, then call make_vulkan_solver.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace fascicle::gpu {

// A Vulkan call that failed ("vkCreateBuffer(...): VK_ERROR_OUT_OF_DEVICE_MEMORY"), or a device that cannot
// run the solver.
struct DeviceError : std::runtime_error {
  using std::runtime_error::runtime_error;
};
// The device is lost, whichever call reported it.
struct DeviceLost : DeviceError {
  using DeviceError::DeviceError;
};

struct DeviceInfo {
  std::uint32_t index = 0;                      // for vulkan:N
  std::string name, type, driver, api_version;  // type: discrete, integrated, virtual, cpu, other
  bool software = false;                        // type cpu
  std::uint64_t memory = 0;                     // bytes of the largest device-local heap
  std::uint64_t max_storage_buffer_range = 0;
  std::uint32_t max_groups = 0;  // per axis x
  std::uint32_t subgroup_size = 0;
  bool rounding_rte = false, signed_zero_inf_nan_preserve = false,
       denorm_preserve = false;  // float controls, 32 bit
  std::string pipelines_key;     // hex digits: devices that share it can use each other's compiled pipelines
  bool usable = true;
  std::string why_not;  // if not usable
};

// All Vulkan devices; empty without a loader or a driver (why_none says which).
std::vector<DeviceInfo> list_devices(std::string* why_none = nullptr);

struct DeviceOptions {
  bool validation = false;  // Khronos validation layer with synchronization validation
  std::function<void(const std::string&)> on_validation_message = {};
  std::string pipelines = {};  // Device::pipelines() of an earlier run; those of another device are ignored
};

// A device opened for compute. Device::Impl is in device_impl.h, for files in gpu/ only.
class Device {
 public:
  explicit Device(std::uint32_t index, const DeviceOptions& options = {});
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  const DeviceInfo& info() const;
  // Runs the self-test kernel over a table of operations and compares bits; `why` gets the first difference.
  bool self_test(std::string* why = nullptr);

  // The driver's compiled form of all pipelines created so far; a later run can reuse it.
  std::string pipelines() const;

  struct Impl;
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace fascicle::gpu
