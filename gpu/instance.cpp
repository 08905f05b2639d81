#include "gpu/instance.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>

#include <unistd.h>

#include "gpu/check.h"

namespace fascicle::gpu {
namespace {

constexpr const char* validation_layer = "VK_LAYER_KHRONOS_validation";

// volk keeps the loader's entry points in global variables. All instances of a process get the same values,
// so they are set once and then only read. Entry points of extensions differ, so they are looked up where
// they are used.
std::mutex& volk_mutex() {
  static std::mutex mutex;
  return mutex;
}

bool has_validation_layer() {
  std::uint32_t count = 0;
  VULKAN_CHECK(vkEnumerateInstanceLayerProperties(&count, nullptr));
  std::vector<VkLayerProperties> layers(count);
  VULKAN_CHECK(vkEnumerateInstanceLayerProperties(&count, layers.data()));
  return std::any_of(layers.begin(), layers.end(), [](const VkLayerProperties& layer) {
    return std::strcmp(layer.layerName, validation_layer) == 0;
  });
}

VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                          VkDebugUtilsMessageTypeFlagsEXT,
                                          const VkDebugUtilsMessengerCallbackDataEXT* data, void* listener) {
  (*static_cast<std::function<void(const std::string&)>*>(listener))(data->pMessage);
  return VK_FALSE;
}

VkDebugUtilsMessengerCreateInfoEXT messenger_info(void* listener) {
  VkDebugUtilsMessengerCreateInfoEXT info{};
  info.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT;
  info.messageSeverity =
      VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  info.messageType =
      VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT;
  info.pfnUserCallback = &on_message;
  info.pUserData = listener;
  return info;
}

// `info` needs only layers, extensions and what extends it.
VkInstance create_instance(VkInstanceCreateInfo info) {
  VkApplicationInfo application{};
  application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
  application.pApplicationName = "fascicle";
  application.apiVersion = VK_API_VERSION_1_1;
  info.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
  info.pApplicationInfo = &application;

  VkInstance instance = VK_NULL_HANDLE;
  const VkResult created = vkCreateInstance(&info, nullptr, &instance);
  if (created == VK_ERROR_INCOMPATIBLE_DRIVER)
    throw DeviceError(
        "the Vulkan loader found no driver; on Debian, mesa-vulkan-drivers has one for most devices");
  const char* layers = std::getenv("VK_INSTANCE_LAYERS");
  if (created != VK_SUCCESS && layers != nullptr && *layers != '\0')
    throw DeviceError(
        "vkCreateInstance: " + text_of(created) + " with VK_INSTANCE_LAYERS=" + layers +
        "; unset it, or install these layers; on Debian, vulkan-validationlayers has Khronos's");
  check(created, "vkCreateInstance");
  const std::scoped_lock lock(volk_mutex());
  if (vkEnumeratePhysicalDevices == nullptr) volkLoadInstanceOnly(instance);
  return instance;
}

// One instance per process, which is never destroyed. NVIDIA's driver (seen with 580.159) creates 30 in a
// process, even if each is destroyed before the next; after that the loader finds no driver. A forked child
// creates its own, because drivers do not work across a fork.
VkInstance instance_of_process() {
  static std::mutex mutex;
  static VkInstance instance = VK_NULL_HANDLE;
  static pid_t creator = 0;
  const std::scoped_lock lock(mutex);
  if (instance == VK_NULL_HANDLE || creator != ::getpid()) {
    instance = create_instance({});
    creator = ::getpid();
  }
  return instance;
}

}  // namespace

bool load_vulkan(std::string* why) {
  const std::scoped_lock lock(volk_mutex());
  if (vkGetInstanceProcAddr == nullptr && volkInitialize() != VK_SUCCESS) {
    if (why) *why = "no Vulkan loader (libvulkan.so.1) on this machine";
    return false;
  }
  if (volkGetInstanceVersion() < VK_API_VERSION_1_1) {
    if (why) *why = "the Vulkan loader supports only Vulkan 1.0; 1.1 is needed";
    return false;
  }
  return true;
}

Instance::Instance(const DeviceOptions& options) {
  std::string why;
  if (!load_vulkan(&why)) throw DeviceError(why);
  if (!options.validation) {
    instance_ = instance_of_process();
    return;
  }
  if (!has_validation_layer())
    throw DeviceError(std::string(validation_layer) +
                      " is not installed; on Debian: vulkan-validationlayers");
  listener_ = std::make_unique<Listener>(options.on_validation_message);
  if (!*listener_)
    *listener_ = [](const std::string& message) { std::fprintf(stderr, "%s\n", message.c_str()); };

  const char* extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
  const VkValidationFeatureEnableEXT enabled[] = {
      VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
  const VkDebugUtilsMessengerCreateInfoEXT messenger = messenger_info(listener_.get());
  VkValidationFeaturesEXT features{};
  features.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT;
  features.pNext = &messenger;
  features.enabledValidationFeatureCount = 1;
  features.pEnabledValidationFeatures = enabled;
  VkInstanceCreateInfo info{};
  info.pNext = &features;
  info.enabledLayerCount = 1;
  info.ppEnabledLayerNames = &validation_layer;
  info.enabledExtensionCount = 2;
  info.ppEnabledExtensionNames = extensions;
  instance_ = create_instance(info);
  owned_.reset(instance_);
  messenger_ = std::make_unique<Messenger>(instance_, messenger);
}

Instance::Messenger::Messenger(VkInstance instance, const VkDebugUtilsMessengerCreateInfoEXT& info)
    : instance_(instance) {
  const auto create = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
      vkGetInstanceProcAddr(instance_, "vkCreateDebugUtilsMessengerEXT"));
  VULKAN_CHECK(create(instance_, &info, nullptr, &handle_));
}

Instance::Messenger::~Messenger() {
  const auto destroy = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
      vkGetInstanceProcAddr(instance_, "vkDestroyDebugUtilsMessengerEXT"));
  destroy(instance_, handle_, nullptr);
}

std::vector<VkPhysicalDevice> Instance::physical_devices() const {
  std::uint32_t count = 0;
  VULKAN_CHECK(vkEnumeratePhysicalDevices(instance_, &count, nullptr));
  std::vector<VkPhysicalDevice> devices(count);
  VULKAN_CHECK(vkEnumeratePhysicalDevices(instance_, &count, devices.data()));
  devices.resize(count);
  return devices;
}

}  // namespace fascicle::gpu
