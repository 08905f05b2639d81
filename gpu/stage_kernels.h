// The solver's compute pipelines.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "gpu/kernel.h"
#include "host/model/solver.h"
#include "host/model/substep_plan.h"

namespace fascicle::gpu {

// The kernels of the schedule, one pipeline each.
using StageKernel = model::Kernel;
inline constexpr std::uint32_t stage_kernel_count = model::kernel_count;

// Tuning for a device; no result depends on it.
struct Tuning {
  std::uint32_t group_size = shader::slice_width;  // invocations per workgroup, a multiple of slice_width
  std::uint32_t ahead = 1;                         // neighbours read ahead of the first use
  bool operator==(const Tuning&) const = default;
};
Tuning tuning_for(const DeviceInfo& device);

// Called between a module and its pipeline: tests use it to see the effect of a different shader.
using AlterModule = std::function<spirv_exact::Words(StageKernel, spirv_exact::Module)>;

class StageKernels {
 public:
  StageKernels(const Device::Impl& device, const model::Model& model, const model::SolverOptions& options,
               spirv_exact::FloatControls controls, const Tuning& tuning, const AlterModule& alter);
  std::uint32_t slices_per_group() const { return slices_per_group_; }
  const Kernel& operator[](StageKernel kernel) const { return kernels_[static_cast<std::uint32_t>(kernel)]; }

 private:
  std::uint32_t slices_per_group_;
  std::vector<Kernel> kernels_;
};

}  // namespace fascicle::gpu
