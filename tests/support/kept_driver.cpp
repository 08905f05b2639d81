// For the address sanitizer only. The Vulkan loader unloads Mesa's driver with each instance. Memory that the
// driver's compiler cached for reuse is then reported as leaked, with a stack without symbols. While the
// driver stays loaded, that memory stays reachable. Does nothing if this driver is not installed.
#include <dlfcn.h>

namespace {

[[maybe_unused]] const void* const kept_driver = dlopen("libvulkan_lvp.so", RTLD_NOW | RTLD_NODELETE);

}  // namespace
