// A compute shader, ready to dispatch.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gpu/device_impl.h"
#include "gpu/owned.h"

namespace fascicle::gpu {

class Kernel {
 public:
  // `constants`: values of the specialisation constants 0, 1, ... The float modes are set in the module; the
  // device must support them.
  Kernel(const Device::Impl& device, spirv_exact::Module module, std::span<const std::uint32_t> constants,
         spirv_exact::FloatControls controls);

  VkPipeline pipeline() const { return pipeline_.get(); }
  VkPipelineLayout layout() const { return layout_.get(); }
  VkDescriptorSetLayout set_layout() const { return set_layout_.get(); }
  // Binding numbers of the buffers that the shader uses (shaders/buffers.h).
  const std::vector<std::uint32_t>& buffers() const { return buffers_; }

 private:
  std::vector<std::uint32_t> buffers_;
  Owned<VkDescriptorSetLayout> set_layout_;
  Owned<VkPipelineLayout> layout_;
  Owned<VkPipeline> pipeline_;
};

}  // namespace fascicle::gpu
