// VulkanSolvers made wrong or slow on purpose, for tests which show that the safeguards are needed and work.
// All such switches are here. Only tests/ may include this header, which a test checks. A solver from
// make_vulkan_solver has none of them.
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
  // Sets no float modes in shaders. Some drivers (Mesa) reorder nothing if float modes are set, so the tests
  // of NoContraction leave them out.
  bool leave_out_float_controls = false;
  // Replaces the device's tuning.
  std::optional<Tuning> tuning = {};
  // Replaces the compiled, exact shaders.
  AlterModule alter_module = {};
  // Limits work further than the pace and the device do.
  SubmissionLimits limits = {};
  // Keeps the first guess of the pace, so that submissions end at the same places however busy the machine
  // is.
  bool keep_pace = false;
  // Called with each submission's slices, with each dispatch's workgroups, and once for each new frame slot.
  std::function<void(std::uint64_t slices)> on_submission = {};
  std::function<void(std::uint32_t groups)> on_dispatch = {};
  std::function<void()> on_new_slot = {};
};

std::unique_ptr<model::Solver> make_experimental_solver(Device& device, const model::Model& model,
                                                        const model::SolverOptions& options,
                                                        const Experiments& experiments);

}  // namespace fascicle::gpu
