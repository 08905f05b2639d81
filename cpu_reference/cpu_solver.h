// CpuSolver: the float solver on the CPU, with the bits of VulkanSolver whatever the number of threads.
#pragma once

#include <memory>

#include "host/model/solver.h"

namespace fascicle::cpu_reference {

// `threads` 0: one for each core. The model must outlive the solver and have passed check_model.
std::unique_ptr<model::Solver> make_cpu_solver(const model::Model& model, const model::SolverOptions& options,
                                               unsigned threads = 0);

}  // namespace fascicle::cpu_reference
