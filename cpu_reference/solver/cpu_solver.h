// CpuSolver: the float solver on the CPU, with the same bits as VulkanSolver for any number of threads and
// any vector instructions. Submit a Drive for each frame and collect its positions (host/model/solver.h).
#pragma once

#include <memory>

#include "cpu_reference/solver/contact_rest.h"
#include "cpu_reference/solver/simd.h"
#include "host/model/solver.h"

namespace fascicle::cpu_reference {

// Data that a solver leaves for the next one, for programs that repeatedly make solvers for similar models.
// It does not change any bit. Copies share their data; each thread may use its own copy.
struct SolverMemory {
  ContactRestMemory contact;
};

// `memory` may be null. `threads` 0: one per core. The model must outlive the solver and have passed
// check_model. Throws std::invalid_argument for options that do not fit the model, and for instructions that
// the machine lacks.
std::unique_ptr<model::Solver> make_cpu_solver(const model::Model& model, const model::SolverOptions& options,
                                               unsigned threads = 0, Simd simd = Simd::automatic,
                                               SolverMemory* memory = nullptr);

}  // namespace fascicle::cpu_reference
