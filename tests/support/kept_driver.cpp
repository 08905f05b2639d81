// For the address sanitizer only. The Vulkan loader unloads Mesa's driver with each instance, and what its
// compiler had kept for the next one is then reported as leaked, with a stack that has no names. A driver
// that stays loaded still points at it. Where there is no such driver nothing is done.
#include <dlfcn.h>

namespace {

[[maybe_unused]] const void* const kept_driver = dlopen("libvulkan_lvp.so", RTLD_NOW | RTLD_NODELETE);

}  // namespace
