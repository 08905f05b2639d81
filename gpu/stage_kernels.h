// The solver's compute pipelines.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "gpu/kernel.h"
#include "host/model/solver.h"

namespace fascicle::gpu {

enum class StageKernel : std::uint32_t {
  rebase,
  skin,
  tie,
  predict,
  region,
  goal,
  relax,
  integrate,
  update,
  iterate,
  embed
};
inline constexpr std::uint32_t stage_kernel_count = 11;

const char* name_of(StageKernel kernel);

// Stands between a module and its pipeline: tests use it to see what goes wrong with a different shader.
using AlterModule = std::function<spirv_exact::Words(StageKernel, spirv_exact::Module)>;

class StageKernels {
 public:
  StageKernels(const Device::Impl& device, const model::Model& model, const model::SolverOptions& options,
               spirv_exact::FloatControls controls, const AlterModule& alter);
  const Kernel& operator[](StageKernel kernel) const { return kernels_[static_cast<std::uint32_t>(kernel)]; }

 private:
  std::vector<Kernel> kernels_;
};

}  // namespace fascicle::gpu
