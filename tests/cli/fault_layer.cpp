// A Vulkan layer with failing calls: FASCICLE_FAULT="K RESULT" makes the Kth call that can fail return the
// VkResult, counted over the whole process; "FUNCTION RESULT" the first call of this function. A lost device
// stays lost. With FASCICLE_FAULT_DISCRETE all devices claim to be discrete GPUs. FASCICLE_FAULT_COUNT names
// a file that receives the number of calls at the end of the process.
#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>

#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

namespace {

constexpr std::array names{"vkAllocateCommandBuffers",
                           "vkAllocateDescriptorSets",
                           "vkAllocateMemory",
                           "vkBeginCommandBuffer",
                           "vkBindBufferMemory",
                           "vkCreateBuffer",
                           "vkCreateCommandPool",
                           "vkCreateComputePipelines",
                           "vkCreateDescriptorPool",
                           "vkCreateDescriptorSetLayout",
                           "vkCreateFence",
                           "vkCreatePipelineCache",
                           "vkCreatePipelineLayout",
                           "vkCreateQueryPool",
                           "vkCreateShaderModule",
                           "vkEndCommandBuffer",
                           "vkEnumerateDeviceExtensionProperties",
                           "vkEnumeratePhysicalDevices",
                           "vkGetPipelineCacheData",
                           "vkGetQueryPoolResults",
                           "vkMapMemory",
                           "vkQueueSubmit",
                           "vkQueueWaitIdle",
                           "vkResetFences",
                           "vkWaitForFences"};

// Vulkan's calls take no context, so this is a singleton. The program uses one driver, whose entry points do
// not change.
struct Faults {
  PFN_vkGetInstanceProcAddr of_instance = nullptr;
  PFN_vkGetDeviceProcAddr of_device = nullptr;
  PFN_vkDestroyInstance destroy_instance = nullptr;
  PFN_vkGetPhysicalDeviceProperties properties = nullptr;
  VkDevice device = VK_NULL_HANDLE;
  PFN_vkDeviceWaitIdle wait_idle = nullptr;
  std::array<PFN_vkVoidFunction, names.size()> real{};
  std::string only;  // if not empty, only calls of this function count
  long failing = 0, calls = 0;
  VkResult result = VK_SUCCESS;
  bool is_lost = false;

  Faults() {
    const char* text = std::getenv("FASCICLE_FAULT");
    std::string which;
    int value = 0;
    if (text == nullptr || !(std::istringstream(text) >> which >> value)) return;
    result = static_cast<VkResult>(value);
    const bool is_named = which.starts_with("vk");
    if (is_named) only = which;
    failing = is_named ? 1 : std::atol(which.c_str());
  }
  // The program keeps its instance, so only its end tells that no calls will follow.
  ~Faults() {
    if (const char* file = std::getenv("FASCICLE_FAULT_COUNT")) std::ofstream(file) << calls << "\n";
  }
  Faults(const Faults&) = delete;
  Faults& operator=(const Faults&) = delete;
};

Faults& faults() {
  static Faults one;
  return one;
}

VkResult next_result(const char* name) {
  Faults& all = faults();
  const bool counts = all.only.empty() || all.only == name;
  if (counts && ++all.calls == all.failing) {
    all.is_lost = all.result == VK_ERROR_DEVICE_LOST;
    // A lost device has no work in flight.
    if (all.is_lost && all.wait_idle != nullptr) all.wait_idle(all.device);
    return all.result;
  }
  return all.is_lost ? VK_ERROR_DEVICE_LOST : VK_SUCCESS;
}

template <std::size_t Index, class Function>
struct Failing;
template <std::size_t Index, class... Arguments>
struct Failing<Index, VkResult (*)(Arguments...)> {
  static VkResult call(Arguments... arguments) {
    if (const VkResult result = next_result(names[Index]); result != VK_SUCCESS) return result;
    return reinterpret_cast<VkResult (*)(Arguments...)>(faults().real[Index])(arguments...);
  }
};

template <std::size_t Index, class Function>
PFN_vkVoidFunction failing() {
  return reinterpret_cast<PFN_vkVoidFunction>(&Failing<Index, Function>::call);
}

bool is_of_instance(const char* name) {
  return std::strncmp(name, "vkEnumerate", 11) == 0;
}

// Null if calls of this name do not fail.
PFN_vkVoidFunction failing_named(const char* name) {
  static const std::array<PFN_vkVoidFunction, names.size()> all{
      failing<0, PFN_vkAllocateCommandBuffers>(),
      failing<1, PFN_vkAllocateDescriptorSets>(),
      failing<2, PFN_vkAllocateMemory>(),
      failing<3, PFN_vkBeginCommandBuffer>(),
      failing<4, PFN_vkBindBufferMemory>(),
      failing<5, PFN_vkCreateBuffer>(),
      failing<6, PFN_vkCreateCommandPool>(),
      failing<7, PFN_vkCreateComputePipelines>(),
      failing<8, PFN_vkCreateDescriptorPool>(),
      failing<9, PFN_vkCreateDescriptorSetLayout>(),
      failing<10, PFN_vkCreateFence>(),
      failing<11, PFN_vkCreatePipelineCache>(),
      failing<12, PFN_vkCreatePipelineLayout>(),
      failing<13, PFN_vkCreateQueryPool>(),
      failing<14, PFN_vkCreateShaderModule>(),
      failing<15, PFN_vkEndCommandBuffer>(),
      failing<16, PFN_vkEnumerateDeviceExtensionProperties>(),
      failing<17, PFN_vkEnumeratePhysicalDevices>(),
      failing<18, PFN_vkGetPipelineCacheData>(),
      failing<19, PFN_vkGetQueryPoolResults>(),
      failing<20, PFN_vkMapMemory>(),
      failing<21, PFN_vkQueueSubmit>(),
      failing<22, PFN_vkQueueWaitIdle>(),
      failing<23, PFN_vkResetFences>(),
      failing<24, PFN_vkWaitForFences>()};
  const auto found = std::find_if(names.begin(), names.end(),
                                  [&](const char* known) { return std::strcmp(known, name) == 0; });
  return found == names.end() ? nullptr : all.at(static_cast<std::size_t>(found - names.begin()));
}

template <class Link, class Info>
Link* link_of(const Info* info, VkStructureType type) {
  auto* next = static_cast<Link*>(const_cast<void*>(info->pNext));
  while (next != nullptr && !(next->sType == type && next->function == VK_LAYER_LINK_INFO))
    next = static_cast<Link*>(const_cast<void*>(next->pNext));
  return next;
}

VkResult create_instance(const VkInstanceCreateInfo* info, const VkAllocationCallbacks* allocation,
                         VkInstance* instance) {
  if (const VkResult result = next_result("vkCreateInstance"); result != VK_SUCCESS) return result;
  auto* link = link_of<VkLayerInstanceCreateInfo>(info, VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO);
  if (link == nullptr) return VK_ERROR_INITIALIZATION_FAILED;
  faults().of_instance = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
  link->u.pLayerInfo = link->u.pLayerInfo->pNext;
  const auto create =
      reinterpret_cast<PFN_vkCreateInstance>(faults().of_instance(nullptr, "vkCreateInstance"));
  const VkResult result = create(info, allocation, instance);
  if (result != VK_SUCCESS) return result;
  faults().destroy_instance =
      reinterpret_cast<PFN_vkDestroyInstance>(faults().of_instance(*instance, "vkDestroyInstance"));
  faults().properties = reinterpret_cast<PFN_vkGetPhysicalDeviceProperties>(
      faults().of_instance(*instance, "vkGetPhysicalDeviceProperties"));
  for (std::size_t k = 0; k < names.size(); ++k)
    if (is_of_instance(names[k])) faults().real[k] = faults().of_instance(*instance, names[k]);
  return result;
}

void destroy_instance(VkInstance instance, const VkAllocationCallbacks* allocation) {
  faults().destroy_instance(instance, allocation);
}

void properties_of_discrete(VkPhysicalDevice device, VkPhysicalDeviceProperties* properties) {
  faults().properties(device, properties);
  properties->deviceType = VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU;
}

VkResult create_device(VkPhysicalDevice physical, const VkDeviceCreateInfo* info,
                       const VkAllocationCallbacks* allocation, VkDevice* device) {
  faults().wait_idle = nullptr;  // one device at a time: the previous one is gone
  if (const VkResult result = next_result("vkCreateDevice"); result != VK_SUCCESS) return result;
  auto* link = link_of<VkLayerDeviceCreateInfo>(info, VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO);
  if (link == nullptr) return VK_ERROR_INITIALIZATION_FAILED;
  const PFN_vkGetInstanceProcAddr of_instance = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
  faults().of_device = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
  link->u.pLayerInfo = link->u.pLayerInfo->pNext;
  const auto create = reinterpret_cast<PFN_vkCreateDevice>(of_instance(nullptr, "vkCreateDevice"));
  const VkResult result = create(physical, info, allocation, device);
  if (result != VK_SUCCESS) return result;
  faults().device = *device;
  faults().wait_idle =
      reinterpret_cast<PFN_vkDeviceWaitIdle>(faults().of_device(*device, "vkDeviceWaitIdle"));
  for (std::size_t k = 0; k < names.size(); ++k)
    if (!is_of_instance(names[k])) faults().real[k] = faults().of_device(*device, names[k]);
  return result;
}

extern "C" {

__attribute__((visibility("default"))) PFN_vkVoidFunction faults_of_device(VkDevice device,
                                                                           const char* name) {
  if (const PFN_vkVoidFunction found = failing_named(name)) return found;
  if (std::strcmp(name, "vkGetDeviceProcAddr") == 0)
    return reinterpret_cast<PFN_vkVoidFunction>(&faults_of_device);
  return faults().of_device(device, name);
}

__attribute__((visibility("default"))) PFN_vkVoidFunction faults_of_instance(VkInstance instance,
                                                                             const char* name) {
  if (std::strcmp(name, "vkCreateInstance") == 0)
    return reinterpret_cast<PFN_vkVoidFunction>(&create_instance);
  if (std::strcmp(name, "vkDestroyInstance") == 0)
    return reinterpret_cast<PFN_vkVoidFunction>(&destroy_instance);
  if (std::strcmp(name, "vkCreateDevice") == 0) return reinterpret_cast<PFN_vkVoidFunction>(&create_device);
  if (std::strcmp(name, "vkGetDeviceProcAddr") == 0)
    return reinterpret_cast<PFN_vkVoidFunction>(&faults_of_device);
  if (std::strcmp(name, "vkGetInstanceProcAddr") == 0)
    return reinterpret_cast<PFN_vkVoidFunction>(&faults_of_instance);
  if (std::strcmp(name, "vkGetPhysicalDeviceProperties") == 0 && std::getenv("FASCICLE_FAULT_DISCRETE"))
    return reinterpret_cast<PFN_vkVoidFunction>(&properties_of_discrete);
  if (is_of_instance(name))
    if (const PFN_vkVoidFunction found = failing_named(name)) return found;
  return faults().of_instance == nullptr ? nullptr : faults().of_instance(instance, name);
}

}  // extern "C"

}  // namespace
