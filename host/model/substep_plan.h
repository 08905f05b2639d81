// The schedule of a substep: which kernels run, in which order and how often, what each reads and writes, and
// what a probe is shown. It stands here alone: CpuSolver, VulkanSolver, Oracle and the measurements of stages
// carry out what substep_plan lists. Barriers between dispatches and which substeps may be swept together
// follow from the accesses. Tests hold those against the compiled shaders and the CPU's kernels.
//
// A new stage is a row of the table in substep_plan.cpp, a place in substep_plan, the kernel
// (shaders/kernel), its shader, its line in CpuSolver's table and the Oracle's function.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string_view>
#include <vector>

#include "host/model/model.h"
#include "host/model/solver.h"

namespace fascicle::model {

// Kernels in the order of their stages. The same word names the shader. lack, crowd and limit are the stage
// limit, and those with contact in their names are the stage contact. update and iterate are fused from
// others, with the same bits.
enum class Kernel : std::uint8_t {
  rebase,
  skin,
  tie,
  contact_bound,
  contact_enclose,
  contact_find,
  contact_survey,
  contact_locate,
  contact_crowd,
  contact_press,
  contact,
  predict,
  region,
  goal,
  relax,
  lack,
  crowd,
  limit,
  integrate,
  update,   // predict, goal and integrate of an explicit substep
  iterate,  // goal and relax of an implicit one
  embed,
};
inline constexpr std::uint32_t kernel_count = 22;

// What changes from substep to substep. Each is a buffer of shaders/buffers.h and an array, or a part of one,
// of cpu_reference/solver/fields.h. There, an explicit substep keeps the velocities that predict makes in
// `predicted`.
enum class Field : std::uint8_t {
  position,
  velocity,
  rotation,
  transform,
  goal,
  skinned,
  skinned_before,
  skinned_velocity,
  gravity,
  surface,
  position_before,
  velocity_before,
  predicted,
  iterate_before,
  tied,
  lack,
  limit_load,
  contact_box,
  contact_branch_box,
  contact_found,
  contact_place,
  contact_range,
  contact_blocks,
  contact_crowd,
  contact_impulse,
  pressed,
};
inline constexpr std::uint32_t field_count = 26;
std::string_view name_of(Field field);

// A set of fields.
struct FieldSet {
  std::uint32_t bits = 0;
  constexpr FieldSet() = default;
  constexpr FieldSet(std::initializer_list<Field> fields) {
    for (const Field f : fields) bits |= 1U << static_cast<std::uint32_t>(f);
  }
  constexpr bool has(Field f) const { return (bits >> static_cast<std::uint32_t>(f) & 1U) != 0; }
  constexpr bool empty() const { return bits == 0; }
  constexpr FieldSet operator|(FieldSet other) const { return of(bits | other.bits); }
  constexpr FieldSet operator&(FieldSet other) const { return of(bits & other.bits); }
  constexpr FieldSet without(FieldSet other) const { return of(bits & ~other.bits); }
  constexpr bool operator==(const FieldSet&) const = default;

 private:
  static constexpr FieldSet of(std::uint32_t bits) {
    FieldSet set;
    set.bits = bits;
    return set;
  }
};

// What a kernel runs over: an invocation, or a turn of a loop, an item.
enum class KernelItems : std::uint8_t {
  vertices,
  limits,
  surface,
  contact_leaves,
  contact_branches,
  contact_points,
  contact_blocks
};

// What a kernel may touch, in any model. An invocation writes only its own item's numbers, so the items of
// one kernel may run in any order: no field that it reads of other items is one that it writes.
struct KernelAccess {
  std::string_view name;
  KernelItems items;
  FieldSet own;   // read at its own item
  FieldSet ring;  // read at the item and in its one-ring
  FieldSet any;   // read anywhere
  FieldSet writes;

  constexpr FieldSet reads() const { return own | ring | any; }
};
const KernelAccess& access_of(Kernel kernel);
std::string_view name_of(Kernel kernel);
std::uint32_t item_count(const Model& model, KernelItems items);

// Whether a kernel that follows others must wait for them: it touches what they wrote, or writes what they
// read. `read` and `written` are of those since the last wait. skinned and skinned_before change places every
// substep and count as one.
bool must_wait(const KernelAccess& next, FieldSet read, FieldSet written);

// A kernel, and what a probe is shown when it is done.
struct Step {
  Kernel kernel;
  std::optional<Stage> shown = std::nullopt;
};

// Steps that run in order, `times` times over.
struct Block {
  enum class Repeat : std::uint8_t { once, iterations, limit_passes };
  Repeat repeat = Repeat::once;
  std::uint32_t times = 1;
  std::vector<Step> steps;
  std::optional<Stage> shown = std::nullopt;  // to a probe, when the last repetition is done
};
using SubstepPlan = std::vector<Block>;

// What a substep of the model runs. For a probe every stage runs by itself; else stages are fused where
// memory is saved by it.
SubstepPlan substep_plan(const Model& model, const SolverOptions& options, bool for_probe);

// The kernels of a plan, each once, in order.
std::vector<Kernel> kernels_of(const SubstepPlan& plan);

// The steps of a block that temporal blocking may carry through several repetitions in one sweep over the
// body (cpu_reference/solver/sweeps.h): a region's map follows the positions of its one-ring, a vertex the
// maps of its one-ring, and `skin`, if any, is the vertex's own affair. None where a step reaches further or
// where the block has other steps.
struct SweptSteps {
  std::optional<Kernel> skin;
  Kernel region, move;
};
std::optional<SweptSteps> swept_steps(const Block& block);

}  // namespace fascicle::model
