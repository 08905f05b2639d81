// An opened device, as files of gpu use it.
#pragma once

#include <memory>
#include <mutex>

#include <volk.h>

#include "gpu/check.h"
#include "gpu/device.h"
#include "gpu/instance.h"
#include "gpu/owned.h"
#include "gpu/physical_device.h"
#include "shaders/spirv_exact/exact.h"

namespace fascicle::gpu {

struct Device::Impl {
  Impl(std::uint32_t index, const DeviceOptions& options);
  ~Impl();
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  const DeviceInfo& info() const { return physical.info; }

  // The float modes to set in shaders on this device.
  spirv_exact::FloatControls float_controls() const;

  // Queues a command buffer; `fence` may be null. Several solvers may share the device.
  void submit(VkCommandBuffer commands, VkFence fence);

  // Waits until everything submitted so far is done.
  void wait_idle();

  // The first memory type of `types` with all of `wanted`, else with all of `needed`. Throws DeviceError if
  // none.
  std::uint32_t memory_type(std::uint32_t types, VkMemoryPropertyFlags wanted,
                            VkMemoryPropertyFlags needed) const;

  Instance instance;
  PhysicalDevice physical;
  VkDevice device = VK_NULL_HANDLE;
  VolkDeviceTable call{};  // the device's own entry points
  VkQueue queue = VK_NULL_HANDLE;

 private:
  struct Destroy {
    PFN_vkDestroyDevice call;
    void operator()(VkDevice owned) const { call(owned, nullptr); }
  };
  std::unique_ptr<VkDevice_T, Destroy> owned_device_;

 public:
  Owned<VkPipelineCache> pipelines;  // destroyed before the device

 private:
  std::mutex queue_mutex_;
};

}  // namespace fascicle::gpu
