// A Vulkan instance, with the validation layer if asked for.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <volk.h>

#include "gpu/device.h"

namespace fascicle::gpu {

// Finds the Vulkan loader; false with the reason where this machine has none. Safe to call from several
// threads.
bool load_vulkan(std::string* why);

class Instance {
 public:
  // Throws DeviceError if there is no loader, or no validation layer though it was asked for.
  explicit Instance(const DeviceOptions& options);
  ~Instance();
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;

  VkInstance get() const { return instance_; }
  std::vector<VkPhysicalDevice> physical_devices() const;

 private:
  using Listener = std::function<void(const std::string&)>;

  VkInstance instance_ = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  std::unique_ptr<Listener> listener_;  // its address is known to the messenger
};

}  // namespace fascicle::gpu
