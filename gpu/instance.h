// A Vulkan instance. The whole process shares one; with the validation layer, each is separate.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <volk.h>

#include "gpu/device.h"

namespace fascicle::gpu {

// Finds the Vulkan loader; returns false and the reason if there is none. Thread-safe.
bool load_vulkan(std::string* why);

class Instance {
 public:
  // Throws DeviceError without a loader, or if the validation layer is requested and missing.
  explicit Instance(const DeviceOptions& options);
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;

  VkInstance get() const { return instance_; }
  std::vector<VkPhysicalDevice> physical_devices() const;

 private:
  using Listener = std::function<void(const std::string&)>;

  struct DestroyInstance {
    void operator()(VkInstance instance) const { vkDestroyInstance(instance, nullptr); }
  };
  // Sends messages to the listener for as long as this lives.
  class Messenger {
   public:
    Messenger(VkInstance instance, const VkDebugUtilsMessengerCreateInfoEXT& info);
    ~Messenger();
    Messenger(const Messenger&) = delete;
    Messenger& operator=(const Messenger&) = delete;

   private:
    VkInstance instance_;
    VkDebugUtilsMessengerEXT handle_ = VK_NULL_HANDLE;
  };

  VkInstance instance_ = VK_NULL_HANDLE;  // the process's, or that of owned_
  // The order matters: creating and destroying the instance sends messages too.
  std::unique_ptr<Listener> listener_;
  std::unique_ptr<VkInstance_T, DestroyInstance> owned_;
  std::unique_ptr<Messenger> messenger_;
};

}  // namespace fascicle::gpu
