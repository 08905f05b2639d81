// The one check of every Vulkan call's result.
#pragma once

#include <string>

#include <volk.h>

#include "gpu/device.h"

namespace fascicle::gpu {

// Its name, or "VkResult N" where it has none here.
std::string text_of(VkResult result);

// Throws DeviceError (DeviceLost) "CALL: RESULT" where the call has not done what it was asked: for every
// error, and for VK_TIMEOUT, after which a fence that was waited for without end is not signalled.
// VK_NOT_READY and VK_INCOMPLETE pass.
void check(VkResult result, const char* call);

}  // namespace fascicle::gpu

#define VULKAN_CHECK(call) ::fascicle::gpu::check((call), #call)
