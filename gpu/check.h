// Checks the result of every Vulkan call.
#pragma once

#include <string>

#include <volk.h>

#include "gpu/device.h"

namespace fascicle::gpu {

// The result's name, or "VkResult N" for one not listed here.
std::string text_of(VkResult result);

// Throws DeviceError (or DeviceLost) "FUNCTION: RESULT" if the call, FUNCTION(...), failed: for every error,
// and for VK_TIMEOUT, since a wait without a timeout has then ended with its fence unsignalled. VK_NOT_READY
// and VK_INCOMPLETE pass.
void check(VkResult result, const char* call);

}  // namespace fascicle::gpu

#define VULKAN_CHECK(call) ::fascicle::gpu::check((call), #call)
