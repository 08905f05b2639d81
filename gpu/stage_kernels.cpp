#include "gpu/stage_kernels.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "gpu/sliced_rings.h"
#include "shaders/buffers.h"
#include "shaders/modules.h"

namespace fascicle::gpu {

Tuning tuning_for(const DeviceInfo& device) {
  // Software devices run one workgroup at a time, and have no load latency to hide.
  if (device.software) return {};
  // Measured in bench/README.md: larger workgroups balance worse. One smaller than a subgroup leaves lanes
  // idle.
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
  constants[shader::constant_ignored_contact] = model.has_ignored_contact() ? 1 : 0;
  constants[shader::constant_near] = is_near(model) ? 1 : 0;
  constants[shader::constant_ahead] = tuning.ahead;
  constants[shader::constant_group_size] = tuning.group_size;
  for (std::uint32_t k = 0; k < stage_kernel_count; ++k) {
    const auto kernel = static_cast<StageKernel>(k);
    const spirv_exact::Module module = shader::module_of(name_of(kernel));
    if (alter)
      kernels_.emplace_back(device, alter(kernel, module), constants, controls);
    else
      kernels_.emplace_back(device, module, constants, controls);
  }
}

}  // namespace fascicle::gpu
