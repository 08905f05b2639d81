// The schedule of a substep: which kernels of stages.h run, in which order and how often, and when a probe is
// shown a stage. It is defined only here: CpuSolver, VulkanSolver, Oracle and the stage timings execute what
// substep_plan lists. Barriers between dispatches, and which substeps may be swept together, follow from the
// kernels' accesses. Tests check those against the compiled shaders and the CPU's kernels.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/model/stages.h"

namespace fascicle::model {

std::uint32_t item_count(const Model& model, KernelItems items);

// Whether a kernel must wait for those before it: it accesses what they wrote, or writes what they read.
// `read` and `written` are the fields accessed since the last wait. skinned and skinned_before swap every
// substep and count as one.
bool must_wait(const KernelAccess& next, FieldSet read, FieldSet written);

// A kernel, and the stage shown to a probe when it is done.
struct Step {
  Kernel kernel;
  std::optional<Stage> shown = std::nullopt;
};

// Steps that run in order, `times` times over.
struct Block {
  enum class Repeat : std::uint8_t { once, iterations, limit_passes, contact_passes };
  Repeat repeat = Repeat::once;
  std::uint32_t times = 1;
  std::vector<Step> steps;
  std::optional<Stage> shown = std::nullopt;  // to a probe, after the last repetition
};
using SubstepPlan = std::vector<Block>;

// The schedule of a substep of the model. For a probe every stage runs by itself; otherwise stages are fused
// where that saves memory traffic.
SubstepPlan substep_plan(const Model& model, const SolverOptions& options, bool for_probe);

// The kernels of a plan, each once, in order.
std::vector<Kernel> kernels_of(const SubstepPlan& plan);

// The steps of a block that temporal blocking may carry through several repetitions in one sweep over the
// body (cpu_reference/solver/sweeps.h): a region's map depends on the positions of its one-ring, a vertex on
// the maps of its one-ring, and `skin`, if any, only on the vertex itself. None if a step reaches further or
// the block has other steps.
struct SweptSteps {
  std::optional<Kernel> skin;
  Kernel region, move;
};
std::optional<SweptSteps> swept_steps(const Block& block);

}  // namespace fascicle::model
