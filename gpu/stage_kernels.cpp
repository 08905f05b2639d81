#include "gpu/stage_kernels.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "gpu/sliced_rings.h"
#include "shaders/buffers.h"
#include "shaders/modules.h"

namespace fascicle::gpu {
namespace {

spirv_exact::Module module_of(StageKernel kernel) {
  switch (kernel) {
    case StageKernel::rebase:
      return shader::rebase_module();
    case StageKernel::skin:
      return shader::skin_module();
    case StageKernel::tie:
      return shader::tie_module();
    case StageKernel::predict:
      return shader::predict_module();
    case StageKernel::region:
      return shader::region_module();
    case StageKernel::goal:
      return shader::goal_module();
    case StageKernel::relax:
      return shader::relax_module();
    case StageKernel::lack:
      return shader::lack_module();
    case StageKernel::crowd:
      return shader::crowd_module();
    case StageKernel::limit:
      return shader::limit_module();
    case StageKernel::integrate:
      return shader::integrate_module();
    case StageKernel::update:
      return shader::update_module();
    case StageKernel::iterate:
      return shader::iterate_module();
    case StageKernel::embed:
      return shader::embed_module();
  }
  return {};
}

}  // namespace

const char* name_of(StageKernel kernel) {
  constexpr std::array<const char*, stage_kernel_count> names{
      "rebase", "skin",  "tie",   "predict",   "region", "goal",    "relax",
      "lack",   "crowd", "limit", "integrate", "update", "iterate", "embed"};
  return names[static_cast<std::uint32_t>(kernel)];
}

Tuning tuning_for(const DeviceInfo& device) {
  // Software devices run one workgroup at a time, and have no loads to wait for.
  if (device.software) return {};
  // Measured, bench/README.md: larger workgroups balance worse. One smaller than a subgroup leaves lanes
  // empty.
  const std::uint32_t width = shader::slice_width;
  return {.group_size = std::max(1u, (device.subgroup_size + width - 1) / width) * width, .ahead = 4};
}

StageKernels::StageKernels(const Device::Impl& device, const model::Model& model,
                           const model::SolverOptions& options, spirv_exact::FloatControls controls,
                           const Tuning& tuning, const AlterModule& alter)
    : slices_per_group_(tuning.group_size / shader::slice_width) {
  assert(tuning.group_size > 0 && tuning.group_size % shader::slice_width == 0 && tuning.ahead > 0);
  std::array<std::uint32_t, shader::constant_count> constants{};
  constants[shader::constant_rotation] =
      options.rotation == model::Rotation::qcp ? shader::rotation_qcp : shader::rotation_mueller2016;
  constants[shader::constant_muscles] = model.muscle_count > 0 ? 1 : 0;
  constants[shader::constant_forces] = model.force_count > 0 ? 1 : 0;
  constants[shader::constant_carried] = model.carried.empty() ? 0 : 1;
  constants[shader::constant_volume] = model.region_volume.empty() ? 0 : 1;
  constants[shader::constant_implicit] = model.is_implicit() ? 1 : 0;
  constants[shader::constant_ties] = model.has_ties() ? 1 : 0;
  constants[shader::constant_near] = is_near(model) ? 1 : 0;
  constants[shader::constant_ahead] = tuning.ahead;
  constants[shader::constant_group_size] = tuning.group_size;
  for (std::uint32_t k = 0; k < stage_kernel_count; ++k) {
    const auto kernel = static_cast<StageKernel>(k);
    if (alter)
      kernels_.emplace_back(device, alter(kernel, module_of(kernel)), constants, controls);
    else
      kernels_.emplace_back(device, module_of(kernel), constants, controls);
  }
}

}  // namespace fascicle::gpu
