// The self-test: runs kernel arithmetic over a table of inputs on the device and compares it with the same
// source compiled as C++.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "gpu/device_impl.h"
#include "shaders/modules.h"

namespace fascicle::gpu {

// The device's results, self_test_results for each row of the table. The module is
// shader::module_of("self_test") and the float modes are the device's, except in tests that show the effect
// of a missing NoContraction.
std::vector<float> run_self_test(Device::Impl& device, spirv_exact::Module module,
                                 spirv_exact::FloatControls controls);

// This CPU's results.
std::vector<float> expected_self_test();

// Describes where the device's results first differ from this CPU's in any bit; empty if they do not.
std::string first_self_test_difference(std::span<const float> device_results);

}  // namespace fascicle::gpu
