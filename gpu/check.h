// The one check of every Vulkan call's result.
#pragma once

#include <volk.h>

#include "gpu/device.h"

namespace fascicle::gpu {

const char* name_of(VkResult result);

// Throws DeviceError "CALL: RESULT" for an error; success codes other than VK_SUCCESS pass.
void check(VkResult result, const char* call);

}  // namespace fascicle::gpu

#define VULKAN_CHECK(call) ::fascicle::gpu::check((call), #call)
