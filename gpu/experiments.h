// A VulkanSolver made wrong or slow on purpose, for tests that show that its safeguards are needed and work.
// All such switches are here. Only tests/ may include this header, which a test checks. A solver made by
// make_vulkan_solver has none of the switches.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "gpu/frame_recorder.h"
#include "gpu/stage_kernels.h"
#include "gpu/vulkan_solver.h"

namespace fascicle::gpu {

struct Experiments {
  // Leaves the barriers between stages out.
  bool leave_out_barriers = false;
  // Gives shaders no float modes. A driver may take those as a reason to reorder nothing (Mesa does), so the
  // tests of NoContraction do without them.
  bool leave_out_float_controls = false;
  // In place of what suits the device.
  std::optional<Tuning> tuning = {};
  // Takes other shaders in place of the compiled, exact ones.
  AlterModule alter_module = {};
  // Work is cut where these say, if they say less than the pace and the device.
  SubmissionLimits limits = {};
  // Called with each submission's slices, each dispatch's workgroups, and once for each frame slot made.
  std::function<void(std::uint64_t slices)> on_submission = {};
  std::function<void(std::uint32_t groups)> on_dispatch = {};
  std::function<void()> on_new_slot = {};
};

std::unique_ptr<model::Solver> make_experimental_solver(Device& device, const model::Model& model,
                                                        const model::SolverOptions& options,
                                                        const Experiments& experiments);

}  // namespace fascicle::gpu
