#include "host/model/substep_plan.h"

#include <algorithm>
#include <array>
#include <utility>

namespace fascicle::model {

namespace {

constexpr FieldSet forces_on_vertex{Field::gravity, Field::tied, Field::pressed};
constexpr FieldSet skin_motion{Field::skinned, Field::skinned_before, Field::skinned_velocity};
constexpr FieldSet history{Field::position_before, Field::velocity_before};

constexpr FieldSet predict_reads =
    forces_on_vertex | skin_motion | history | FieldSet{Field::position, Field::velocity};
// The implicit integrator's way of integrate also takes what relax left.
constexpr FieldSet integrate_reads =
    skin_motion.without({Field::skinned_velocity}) |
    FieldSet{Field::position, Field::velocity, Field::goal, Field::predicted};
constexpr FieldSet integrate_writes{Field::position, Field::velocity, Field::skinned_velocity};
constexpr FieldSet relax_reads{Field::position, Field::iterate_before, Field::predicted};
constexpr FieldSet relax_writes{Field::position, Field::iterate_before};

// One row a kernel, in the order of the enumeration: name, items, own, ring, any, writes.
constexpr std::array<KernelAccess, kernel_count> table{{
    {"rebase",
     KernelItems::vertices,
     {Field::position, Field::skinned, Field::position_before},
     {},
     {},
     {Field::position, Field::skinned, Field::position_before}},
    {"skin", KernelItems::vertices, {}, {}, {}, {Field::skinned, Field::gravity}},
    {"tie", KernelItems::vertices, {}, {}, {Field::position, Field::velocity}, {Field::tied}},
    {"contact_bound",
     KernelItems::contact_leaves,
     {},
     {},
     {Field::position, Field::velocity},
     {Field::contact_box}},
    {"contact_enclose",
     KernelItems::contact_branches,
     {},
     {},
     {Field::contact_box},
     {Field::contact_branch_box}},
    {"contact_find",
     KernelItems::contact_points,
     {},
     {},
     {Field::position, Field::velocity, Field::contact_box, Field::contact_branch_box},
     {Field::contact_found, Field::contact_place}},
    {"contact_survey", KernelItems::contact_blocks, {}, {}, {Field::contact_found}, {Field::contact_range}},
    {"contact_locate", KernelItems::contact_leaves, {}, {}, {Field::contact_range}, {Field::contact_blocks}},
    {"contact_crowd",
     KernelItems::vertices,
     {},
     {},
     {Field::contact_found, Field::contact_place, Field::contact_blocks},
     {Field::contact_crowd}},
    {"contact_press",
     KernelItems::contact_points,
     {Field::contact_found, Field::contact_place},
     {},
     {Field::velocity, Field::contact_crowd},
     {Field::contact_impulse}},
    {"contact",
     KernelItems::vertices,
     {},
     {},
     {Field::contact_found, Field::contact_place, Field::contact_blocks, Field::contact_impulse},
     {Field::pressed}},
    {"predict",
     KernelItems::vertices,
     predict_reads,
     {},
     {},
     history | FieldSet{Field::position, Field::velocity, Field::predicted, Field::iterate_before}},
    {"region",
     KernelItems::vertices,
     {Field::rotation},
     {Field::position},
     {},
     {Field::rotation, Field::transform}},
    {"goal", KernelItems::vertices, {}, {Field::transform}, {}, {Field::goal}},
    {"relax", KernelItems::vertices, relax_reads | FieldSet{Field::goal}, {}, {}, relax_writes},
    {"lack", KernelItems::limits, {}, {}, {Field::position}, {Field::lack}},
    {"crowd",
     KernelItems::vertices,
     {Field::position},
     {},
     {Field::lack},
     {Field::limit_load, Field::iterate_before}},
    {"limit",
     KernelItems::vertices,
     {Field::position, Field::predicted, Field::goal, Field::velocity},
     {},
     {Field::iterate_before, Field::lack, Field::limit_load},
     {Field::position, Field::predicted, Field::goal, Field::velocity}},
    {"integrate", KernelItems::vertices, integrate_reads, {}, {}, integrate_writes},
    {"update",
     KernelItems::vertices,
     forces_on_vertex | skin_motion | FieldSet{Field::position, Field::velocity},
     {Field::transform},
     {},
     integrate_writes},
    {"iterate",
     KernelItems::vertices,
     relax_reads,
     {Field::transform},
     {},
     relax_writes | FieldSet{Field::goal}},
    {"embed", KernelItems::surface, {}, {}, {Field::position}, {Field::surface}},
}};

constexpr bool items_are_independent() {
  return std::all_of(table.begin(), table.end(),
                     [](const KernelAccess& row) { return ((row.ring | row.any) & row.writes).empty(); });
}
static_assert(items_are_independent(), "a kernel reads of other items what it writes");

constexpr FieldSet both_skins{Field::skinned, Field::skinned_before};

FieldSet with_both_skins(FieldSet set) {
  return (set & both_skins).empty() ? set : set | both_skins;
}

}  // namespace

std::string_view name_of(Field field) {
  constexpr std::array<std::string_view, field_count> names{"position",
                                                            "velocity",
                                                            "rotation",
                                                            "transform",
                                                            "goal",
                                                            "skinned",
                                                            "skinned_before",
                                                            "skinned_velocity",
                                                            "gravity",
                                                            "surface",
                                                            "position_before",
                                                            "velocity_before",
                                                            "predicted",
                                                            "iterate_before",
                                                            "tied",
                                                            "lack",
                                                            "limit_load",
                                                            "contact_box",
                                                            "contact_branch_box",
                                                            "contact_found",
                                                            "contact_place",
                                                            "contact_range",
                                                            "contact_blocks",
                                                            "contact_crowd",
                                                            "contact_impulse",
                                                            "pressed"};
  return names[static_cast<std::size_t>(field)];
}

const KernelAccess& access_of(Kernel kernel) {
  return table[static_cast<std::size_t>(kernel)];
}

std::string_view name_of(Kernel kernel) {
  return access_of(kernel).name;
}

std::uint32_t item_count(const Model& model, KernelItems items) {
  switch (items) {
    case KernelItems::vertices:
      return model.vertex_count;
    case KernelItems::limits:
      return static_cast<std::uint32_t>(model.limit.size());
    case KernelItems::surface:
      return model.surface_count();
    case KernelItems::contact_leaves:
      return model.contact_leaf_count();
    case KernelItems::contact_branches:
      return model.contact_branch_count();
    case KernelItems::contact_points:
      return static_cast<std::uint32_t>(model.contact.size());
    case KernelItems::contact_blocks:
      return model.contact_block_count();
  }
  return 0;
}

bool must_wait(const KernelAccess& next, FieldSet read, FieldSet written) {
  const FieldSet touches = with_both_skins(next.reads() | next.writes);
  return !(touches & with_both_skins(written)).empty() ||
         !(with_both_skins(next.writes) & with_both_skins(read)).empty();
}

namespace {

void append(std::vector<Step>& steps, std::initializer_list<Step> more) {
  for (const Step& step : more) steps.push_back(step);
}

}  // namespace

SubstepPlan substep_plan(const Model& model, const SolverOptions& options, bool for_probe) {
  SubstepPlan plan;
  std::vector<Step> begin;
  if (model.has_skeleton()) begin.push_back({Kernel::skin, Stage::skin});
  if (model.has_ties()) begin.push_back({Kernel::tie, Stage::tie});
  if (model.has_contact()) {
    if (!begin.empty()) plan.push_back({.steps = std::exchange(begin, {})});
    plan.push_back({.steps = {{Kernel::contact_bound},
                              {Kernel::contact_enclose},
                              {Kernel::contact_find},
                              {Kernel::contact_survey},
                              {Kernel::contact_locate},
                              {Kernel::contact_crowd},
                              {Kernel::contact_press},
                              {Kernel::contact}},
                    .shown = Stage::contact});
  }
  const Step predict{Kernel::predict, Stage::predict}, region{Kernel::region, Stage::region},
      goal{Kernel::goal, Stage::goal}, integrate{Kernel::integrate, Stage::integrate};

  if (!model.is_implicit()) {
    // Ties and contacts reach anywhere. What follows them is a block of its own, which can be swept.
    if (model.has_ties() && !begin.empty()) plan.push_back({.steps = std::exchange(begin, {})});
    if (for_probe)
      append(begin, {predict, region, goal, integrate});
    else
      append(begin, {region, {Kernel::update, Stage::integrate}});
    plan.push_back({.steps = std::move(begin)});
    return plan;
  }

  begin.push_back(predict);
  plan.push_back({.steps = std::move(begin)});
  Block iterations{Block::Repeat::iterations, options.iterations, {region}};
  if (for_probe)
    append(iterations.steps, {goal, {Kernel::relax, Stage::relax}});
  else
    iterations.steps.push_back({Kernel::iterate, Stage::relax});
  plan.push_back(std::move(iterations));
  if (model.has_limits())
    plan.push_back({Block::Repeat::limit_passes,
                    shader::limit_passes,
                    {{Kernel::lack}, {Kernel::crowd}, {Kernel::limit}},
                    Stage::limit});
  plan.push_back({.steps = {integrate}});
  return plan;
}

std::vector<Kernel> kernels_of(const SubstepPlan& plan) {
  std::vector<Kernel> kernels;
  for (const Block& block : plan)
    for (const Step& step : block.steps)
      if (std::find(kernels.begin(), kernels.end(), step.kernel) == kernels.end())
        kernels.push_back(step.kernel);
  return kernels;
}

std::optional<SweptSteps> swept_steps(const Block& block) {
  const std::size_t count = block.steps.size();
  if (count < 2 || count > 3) return std::nullopt;
  const Kernel region = block.steps[count - 2].kernel, move = block.steps[count - 1].kernel;
  std::optional<Kernel> skin;
  if (count == 3) skin = block.steps.front().kernel;
  for (const Step& step : block.steps) {
    const KernelAccess& access = access_of(step.kernel);
    if (access.items != KernelItems::vertices || !access.any.empty()) return std::nullopt;
  }
  const KernelAccess &of_region = access_of(region), &of_move = access_of(move);
  // Each takes of its neighbours what the other leaves them, and nothing else.
  if (of_region.ring.empty() || of_move.ring.empty()) return std::nullopt;
  if (!of_region.ring.without(of_move.writes).empty() || !of_move.ring.without(of_region.writes).empty())
    return std::nullopt;
  // What comes before both is run with `move`, after the region's map of the same pass.
  if (skin) {
    const KernelAccess& of_skin = access_of(*skin);
    if (!of_skin.ring.empty() || must_wait(of_region, of_skin.reads(), of_skin.writes)) return std::nullopt;
  }
  return SweptSteps{skin, region, move};
}

}  // namespace fascicle::model
