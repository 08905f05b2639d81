// The result of `fascicle validate`, as a page.
#pragma once

#include <string>
#include <vector>

#include "host/cli/compare_devices.h"
#include "host/cli/convergence.h"

namespace fascicle::cli {

std::string validation_page(const scene::Scene& scene, const Built& built,
                            const std::vector<ChosenDevice>& devices, const Validation& validation);

// For --converged.
std::string convergence_page(const scene::Scene& scene, const Convergence& convergence);

}  // namespace fascicle::cli
