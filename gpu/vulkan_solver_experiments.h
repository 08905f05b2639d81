// A VulkanSolver made wrong on purpose, for the tests that show that its safeguards are needed and seen to
// be.
#pragma once

#include <memory>

#include "gpu/stage_kernels.h"
#include "gpu/vulkan_solver.h"

namespace fascicle::gpu {

struct Experiments {
  bool leave_out_barriers = false;  // between stages
  AlterModule alter_module;         // in place of the compiled, exact shaders
};

std::unique_ptr<model::Solver> make_vulkan_solver(Device& device, const model::Model& model,
                                                  const model::SolverOptions& options,
                                                  const Experiments& experiments);

}  // namespace fascicle::gpu
