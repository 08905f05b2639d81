// Every device is destroyed, also if opening it fails. An instance is destroyed unless the process shares it.
#include <cstring>
#include <string>
#include <utility>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>
#include <volk.h>

#include "cpu_reference/solver/cpu_solver.h"
#include "gpu/device.h"
#include "gpu/frame_slot.h"
#include "gpu/vulkan_solver.h"
#include "tests/gpu/vulkan_device.h"
#include "tests/support/bar_model.h"

namespace fascicle::tests {
namespace {

// volk's original entry points, and the calls counted by their replacements. Vulkan's calls take no context
// of ours, so this is a singleton.
struct Faults {
  PFN_vkGetInstanceProcAddr of_instance = nullptr;
  PFN_vkGetDeviceProcAddr of_device = nullptr;
  PFN_vkCreateInstance create_instance = nullptr;
  PFN_vkDestroyInstance destroy_instance = nullptr;
  PFN_vkDestroyDevice destroy_device = nullptr;
  PFN_vkAllocateMemory allocate = nullptr;
  PFN_vkGetQueryPoolResults query = nullptr;
  std::string failing;
  int allocations_left = -1;  // until one fails; -1: none does
  bool fails_next_query = false;
  int instances_created = 0, instances_destroyed = 0, devices_destroyed = 0;
};

Faults& faults() {
  static Faults one;
  return one;
}

VKAPI_ATTR VkResult VKAPI_CALL no_cache(VkDevice, const VkPipelineCacheCreateInfo*,
                                        const VkAllocationCallbacks*, VkPipelineCache*) {
  return VK_ERROR_OUT_OF_HOST_MEMORY;
}

VKAPI_ATTR VkResult VKAPI_CALL limited_allocation(VkDevice device, const VkMemoryAllocateInfo* info,
                                                  const VkAllocationCallbacks* callbacks,
                                                  VkDeviceMemory* memory) {
  if (faults().allocations_left == 0) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
  if (faults().allocations_left > 0) --faults().allocations_left;
  return faults().allocate(device, info, callbacks, memory);
}

VKAPI_ATTR VkResult VKAPI_CALL faulty_query(VkDevice device, VkQueryPool pool, std::uint32_t first,
                                            std::uint32_t count, std::size_t size, void* data,
                                            VkDeviceSize stride, VkQueryResultFlags flags) {
  if (std::exchange(faults().fails_next_query, false)) return VK_ERROR_OUT_OF_HOST_MEMORY;
  return faults().query(device, pool, first, count, size, data, stride, flags);
}

VKAPI_ATTR VkResult VKAPI_CALL no_messenger(VkInstance, const VkDebugUtilsMessengerCreateInfoEXT*,
                                            const VkAllocationCallbacks*, VkDebugUtilsMessengerEXT*) {
  return VK_ERROR_OUT_OF_HOST_MEMORY;
}

VKAPI_ATTR VkResult VKAPI_CALL counted_creation(const VkInstanceCreateInfo* info,
                                                const VkAllocationCallbacks* allocation,
                                                VkInstance* instance) {
  ++faults().instances_created;
  return faults().create_instance(info, allocation, instance);
}

VKAPI_ATTR void VKAPI_CALL counted_instance(VkInstance instance, const VkAllocationCallbacks* allocation) {
  ++faults().instances_destroyed;
  faults().destroy_instance(instance, allocation);
}

VKAPI_ATTR void VKAPI_CALL counted_device(VkDevice device, const VkAllocationCallbacks* allocation) {
  ++faults().devices_destroyed;
  faults().destroy_device(device, allocation);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL faulty_of_device(VkDevice device, const char* name) {
  const PFN_vkVoidFunction real = faults().of_device(device, name);
  if (std::strcmp(name, "vkDestroyDevice") == 0) {
    faults().destroy_device = reinterpret_cast<PFN_vkDestroyDevice>(real);
    return reinterpret_cast<PFN_vkVoidFunction>(&counted_device);
  }
  if (std::strcmp(name, "vkAllocateMemory") == 0) {
    faults().allocate = reinterpret_cast<PFN_vkAllocateMemory>(real);
    return reinterpret_cast<PFN_vkVoidFunction>(&limited_allocation);
  }
  if (std::strcmp(name, "vkGetQueryPoolResults") == 0) {
    faults().query = reinterpret_cast<PFN_vkGetQueryPoolResults>(real);
    return reinterpret_cast<PFN_vkVoidFunction>(&faulty_query);
  }
  if (faults().failing == name && faults().failing == "vkCreatePipelineCache")
    return reinterpret_cast<PFN_vkVoidFunction>(&no_cache);
  return real;
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL faulty_of_instance(VkInstance instance, const char* name) {
  if (faults().failing == name && faults().failing == "vkCreateDebugUtilsMessengerEXT")
    return reinterpret_cast<PFN_vkVoidFunction>(&no_messenger);
  return faults().of_instance(instance, name);
}

class Failures : public VulkanTest {
 protected:
  // Searching for a device has loaded Vulkan.
  void SetUp() override {
    VulkanTest::SetUp();
    if (!index) return;
    faults() = {.of_instance = vkGetInstanceProcAddr,
                .of_device = vkGetDeviceProcAddr,
                .create_instance = vkCreateInstance,
                .destroy_instance = vkDestroyInstance,
                .failing = {}};
    vkGetInstanceProcAddr = &faulty_of_instance;
    vkGetDeviceProcAddr = &faulty_of_device;
    vkCreateInstance = &counted_creation;
    vkDestroyInstance = &counted_instance;
  }
  void TearDown() override {
    if (!index) return;
    vkGetInstanceProcAddr = faults().of_instance;
    vkGetDeviceProcAddr = faults().of_device;
    vkCreateInstance = faults().create_instance;
    vkDestroyInstance = faults().destroy_instance;
  }

  std::string message(const gpu::DeviceOptions& options) const {
    try {
      const gpu::Device device(*index, options);
    } catch (const gpu::DeviceError& error) {
      return error.what();
    }
    return "opened";
  }
};

// NVIDIA's driver creates 30 instances in a process and then no more, so 40 devices must not need 40.
TEST_F(Failures, NoneDestroysEachDeviceAndKeepsTheInstance) {
  for (int k = 0; k < 40; ++k) {
    EXPECT_FALSE(gpu::list_devices().empty());
    EXPECT_EQ(message({}), "opened");
  }
  EXPECT_EQ(faults().devices_destroyed, 40);
  EXPECT_EQ(faults().instances_created, 0);
  EXPECT_EQ(faults().instances_destroyed, 0);
}

// The control of OfTheMessengerDestroysTheInstance: the counter registers what is normally destroyed.
TEST_F(Failures, NoneDestroysAValidatedInstance) {
  if (const std::string said = message({.validation = true}); said != "opened") {
    if (vulkan_is_required()) FAIL() << said;
    GTEST_SKIP() << "NOTHING WAS TESTED: " << said;
  }
  EXPECT_EQ(faults().devices_destroyed, 1);
  EXPECT_EQ(faults().instances_created, 1);
  EXPECT_EQ(faults().instances_destroyed, 1);
}

TEST_F(Failures, OfThePipelineCacheDestroysTheDevice) {
  faults().failing = "vkCreatePipelineCache";
  const std::string said = message({});
  EXPECT_NE(said.find("vkCreatePipelineCache"), std::string::npos) << said;
  EXPECT_NE(said.find("VK_ERROR_OUT_OF_HOST_MEMORY"), std::string::npos) << said;
  EXPECT_EQ(faults().devices_destroyed, 1);
}

// As in Python's multiprocessing: the parent has used the device, and a child uses it too.
TEST_F(Failures, OfAForkAreNone) {
#ifdef __SANITIZE_THREAD__
  GTEST_SKIP() << "the thread sanitizer cannot start threads after a fork";
#endif
  EXPECT_EQ(message({}), "opened");
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    ::alarm(60);
    try {
      gpu::Device device(*index);
      ::_exit(faults().instances_created == 1 && device.self_test() ? 0 : 1);
    } catch (...) {
      ::_exit(2);  // else the child would run the other tests
    }
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(message({}), "opened");
}

// Another program takes the device's memory. After the load that the solver's contract asks for, frames have
// the bits that they would have had.
TEST_F(Failures, OfAllocationsEndWithALoad) {
  const model::Model model = make_bar({.skeleton = true, .muscle = true, .forces = true, .implicit = true});
  const model::SolverOptions options{.integrator = model::Integrator::implicit_step, .iterations = 4};
  const model::Read all{.positions = true, .velocities = true, .surface = true};
  gpu::Device device(*index);
  const auto cpu = cpu_reference::make_cpu_solver(model, options, 1);
  BarMotion few(model, 2), many(model, 9);  // more substeps need a larger drive and other tables
  int failures = 0;
  for (bool has_failed = true; has_failed;) {
    const auto solver = gpu::make_vulkan_solver(device, model, options);
    cpu->load(solver->save());
    for (model::Solver* each : {solver.get(), cpu.get()}) {
      each->submit(few.drive(1), all);
      each->collect();
    }
    const model::State state = solver->save();
    faults().allocations_left = failures;
    has_failed = false;
    try {
      solver->submit(many.drive(2), all);
      solver->collect();
    } catch (const gpu::DeviceError& error) {
      EXPECT_NE(std::string(error.what()).find("OUT_OF_DEVICE_MEMORY"), std::string::npos) << error.what();
      has_failed = true;
      ++failures;
    }
    faults().allocations_left = -1;
    // First with the substeps of before.
    for (BarMotion* motion : {&few, &many}) {
      for (model::Solver* each : {solver.get(), cpu.get()}) {
        each->load(state);
        each->submit(motion->drive(2), all);
      }
      const model::Frame frame = solver->collect(), reference = cpu->collect();
      EXPECT_EQ(frame.positions, reference.positions) << failures;
      EXPECT_EQ(frame.velocities, reference.velocities) << failures;
      EXPECT_EQ(frame.surface, reference.surface) << failures;
    }
  }
  EXPECT_GE(failures, 10) << "the old state, the tables, the upload and the drive";
}

// The frame is done, but cannot be collected for lack of memory: a load must not wait for it once more.
TEST_F(Failures, OfACollectEndWithALoad) {
  const model::Model model = make_bar({.skeleton = true, .muscle = true, .forces = true});
  const model::Read all{.positions = true, .velocities = true, .surface = true};
  gpu::Device device(*index);
  const auto solver = gpu::make_vulkan_solver(device, model, {});
  const auto cpu = cpu_reference::make_cpu_solver(model, {}, 1);
  BarMotion motion(model, 2);
  const model::State state = solver->save();
  for (std::uint32_t frame = 1; frame <= 3; ++frame) solver->submit(motion.drive(frame), all);
  faults().fails_next_query = true;
  bool has_failed = false;
  try {
    solver->collect();
  } catch (const gpu::DeviceError&) {
    has_failed = true;
  }
  if (faults().fails_next_query) GTEST_SKIP() << "NOTHING WAS TESTED: the device has no timestamps";
  EXPECT_TRUE(has_failed);
  for (model::Solver* each : {solver.get(), cpu.get()}) each->load(state);
  // More than are in flight at once: each slot is used again.
  for (std::uint32_t frame = 1; frame <= 2 * gpu::most_frames_in_flight; ++frame) {
    for (model::Solver* each : {solver.get(), cpu.get()}) each->submit(motion.drive(frame), all);
    const model::Frame found = solver->collect(), expected = cpu->collect();
    EXPECT_EQ(found.index, frame);
    EXPECT_EQ(found.positions, expected.positions);
    EXPECT_EQ(found.velocities, expected.velocities);
    EXPECT_EQ(found.surface, expected.surface);
  }
}

// Each device keeps its number.
TEST_F(Failures, OfADriverLeavesTheOtherDevices) {
  static int queries_left = 0;
  static PFN_vkEnumerateDeviceExtensionProperties enumerate = nullptr;
  const std::vector<gpu::DeviceInfo> before = gpu::list_devices();
  enumerate = vkEnumerateDeviceExtensionProperties;
  vkEnumerateDeviceExtensionProperties = [](VkPhysicalDevice device, const char* layer, std::uint32_t* count,
                                            VkExtensionProperties* properties) {
    return queries_left-- > 0 ? enumerate(device, layer, count, properties) : VK_ERROR_OUT_OF_HOST_MEMORY;
  };
  queries_left = 2 * static_cast<int>(before.size()) - 1;  // two for each device: the last fails
  const std::vector<gpu::DeviceInfo> after = gpu::list_devices();
  vkEnumerateDeviceExtensionProperties = enumerate;
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t k = 0; k < after.size(); ++k) {
    EXPECT_EQ(after[k].index, k);
    EXPECT_EQ(after[k].name, before[k].name);
    EXPECT_EQ(after[k].usable, before[k].usable && k + 1 < after.size());
  }
  EXPECT_NE(after.back().why_not.find("its driver failed"), std::string::npos) << after.back().why_not;
}

TEST_F(Failures, OfTheMessengerDestroysTheInstance) {
  const gpu::DeviceOptions validated{.validation = true};
  if (const std::string said = message(validated); said != "opened") {
    if (vulkan_is_required()) FAIL() << said;
    GTEST_SKIP() << "NOTHING WAS TESTED: " << said;
  }
  faults().instances_destroyed = faults().devices_destroyed = 0;
  faults().failing = "vkCreateDebugUtilsMessengerEXT";
  const std::string said = message(validated);
  EXPECT_NE(said.find("VK_ERROR_OUT_OF_HOST_MEMORY"), std::string::npos) << said;
  EXPECT_EQ(faults().devices_destroyed, 0);
  EXPECT_EQ(faults().instances_destroyed, 1);
}

}  // namespace
}  // namespace fascicle::tests
