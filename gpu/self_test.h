// The self-test: kernel arithmetic over a table of inputs on the device, against the same source compiled as
// C++.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "gpu/device_impl.h"
#include "shaders/modules.h"

namespace fascicle::gpu {

// Results of the device, self_test_results for each row of the table. The module is
// shader::module_of("self_test") and the float modes the device's, but for the tests that show what a missing
// NoContraction does.
std::vector<float> run_self_test(Device::Impl& device, spirv_exact::Module module,
                                 spirv_exact::FloatControls controls);

// Results of this CPU.
std::vector<float> expected_self_test();

// Where the device's results first differ from this CPU's by bits, in words; empty if nowhere.
std::string first_self_test_difference(std::span<const float> device_results);

}  // namespace fascicle::gpu
