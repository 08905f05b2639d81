#include "gpu/kernel.h"

#include "shaders/buffers.h"

namespace fascicle::gpu {
namespace {

Owned<VkShaderModule> make_module(const Device::Impl& device, spirv_exact::Module words,
                                  spirv_exact::FloatControls controls) {
  const spirv_exact::Words code = spirv_exact::add_float_controls(words, controls);
  VkShaderModuleCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
  info.codeSize = code.size() * sizeof(std::uint32_t);
  info.pCode = code.data();
  VkShaderModule module = VK_NULL_HANDLE;
  VULKAN_CHECK(device.call.vkCreateShaderModule(device.device, &info, nullptr, &module));
  return {device.device, module, device.call.vkDestroyShaderModule};
}

Owned<VkDescriptorSetLayout> make_set_layout(const Device::Impl& device,
                                             const std::vector<std::uint32_t>& buffers) {
  std::vector<VkDescriptorSetLayoutBinding> bindings;
  for (const std::uint32_t b : buffers)
    bindings.push_back({b, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr});
  VkDescriptorSetLayoutCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
  info.bindingCount = static_cast<std::uint32_t>(bindings.size());
  info.pBindings = bindings.data();
  VkDescriptorSetLayout layout = VK_NULL_HANDLE;
  VULKAN_CHECK(device.call.vkCreateDescriptorSetLayout(device.device, &info, nullptr, &layout));
  return {device.device, layout, device.call.vkDestroyDescriptorSetLayout};
}

Owned<VkPipelineLayout> make_layout(const Device::Impl& device, VkDescriptorSetLayout set_layout) {
  const VkPushConstantRange push{VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(shader::Push)};
  VkPipelineLayoutCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
  info.setLayoutCount = 1;
  info.pSetLayouts = &set_layout;
  info.pushConstantRangeCount = 1;
  info.pPushConstantRanges = &push;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VULKAN_CHECK(device.call.vkCreatePipelineLayout(device.device, &info, nullptr, &layout));
  return {device.device, layout, device.call.vkDestroyPipelineLayout};
}

}  // namespace

Kernel::Kernel(const Device::Impl& device, spirv_exact::Module module,
               std::span<const std::uint32_t> constants, spirv_exact::FloatControls controls)
    : buffers_(spirv_exact::used_bindings(module)),
      set_layout_(make_set_layout(device, buffers_)),
      layout_(make_layout(device, set_layout_.get())) {
  std::vector<VkSpecializationMapEntry> entries;
  for (std::uint32_t c = 0; c < constants.size(); ++c)
    entries.push_back({c, c * static_cast<std::uint32_t>(sizeof(std::uint32_t)), sizeof(std::uint32_t)});
  VkSpecializationInfo specialisation{};
  specialisation.mapEntryCount = static_cast<std::uint32_t>(entries.size());
  specialisation.pMapEntries = entries.data();
  specialisation.dataSize = constants.size_bytes();
  specialisation.pData = constants.data();

  const Owned<VkShaderModule> shader_module = make_module(device, module, controls);
  VkComputePipelineCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO;
  info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
  info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  info.stage.module = shader_module.get();
  info.stage.pName = "main";
  info.stage.pSpecializationInfo = &specialisation;
  info.layout = layout_.get();
  VkPipeline pipeline = VK_NULL_HANDLE;
  VULKAN_CHECK(device.call.vkCreateComputePipelines(device.device, device.pipelines.get(), 1, &info, nullptr,
                                                    &pipeline));
  pipeline_ = {device.device, pipeline, device.call.vkDestroyPipeline};
}

}  // namespace fascicle::gpu
