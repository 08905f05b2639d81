#include "host/model/substep_plan.h"

#include <algorithm>
#include <utility>

namespace fascicle::model {

namespace {

constexpr FieldSet both_skins{Field::skinned, Field::skinned_before};

FieldSet with_both_skins(FieldSet set) {
  return (set & both_skins).empty() ? set : set | both_skins;
}

}  // namespace

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
    case KernelItems::contact_tetrahedra:
      return model.contact_tetrahedron_count();
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
  if (model.has_contact())
    plan.push_back({.steps = {{Kernel::contact_bound},
                              {Kernel::contact_enclose},
                              {Kernel::contact_find},
                              {Kernel::contact_chain},
                              {Kernel::contact_crowd}}});
  const Block respond{Block::Repeat::contact_passes,
                      shader::contact_passes,
                      {{Kernel::contact_press}, {Kernel::contact}},
                      Stage::contact};
  const Step predict{Kernel::predict, Stage::predict}, region{Kernel::region, Stage::region},
      goal{Kernel::goal, Stage::goal}, collide{Kernel::collide, Stage::collide},
      integrate{Kernel::integrate, Stage::integrate};

  if (!model.is_implicit()) {
    // Ties reach anywhere, so they get their own block. What follows can be swept.
    if (model.has_ties() && !begin.empty()) plan.push_back({.steps = std::exchange(begin, {})});
    if (for_probe)
      append(begin, {predict, region, goal, integrate});
    else
      append(begin, {region, {Kernel::update, Stage::integrate}});
    plan.push_back({.steps = std::move(begin)});
    if (model.has_contact()) plan.push_back(respond);
    if (model.has_colliders()) plan.push_back({.steps = {collide}});
    return plan;
  }

  begin.push_back(predict);
  plan.push_back({.steps = std::move(begin)});
  Block iterations{Block::Repeat::iterations, options.iterations, {region}};
  if (for_probe)
    append(iterations.steps, {goal, {Kernel::relax, Stage::relax}});
  else
    iterations.steps.push_back({Kernel::iterate, Stage::relax});
  if (model.has_contact())
    append(iterations.steps, {{Kernel::contact_hold}, {Kernel::contact_yield, Stage::contact}});
  if (model.has_colliders()) iterations.steps.push_back({Kernel::obstruct});
  plan.push_back(std::move(iterations));
  if (model.has_limits())
    plan.push_back({Block::Repeat::limit_passes,
                    shader::limit_passes,
                    {{Kernel::lack}, {Kernel::crowd}, {Kernel::limit}},
                    Stage::limit});
  if (model.has_colliders()) plan.push_back({.steps = {collide}});
  plan.push_back({.steps = {integrate}});
  if (model.has_contact())
    plan.push_back({.steps = {{Kernel::contact_settle}, {Kernel::contact_rest, Stage::contact}}});
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
  // Each reads from its neighbours only what the other writes.
  if (of_region.ring.empty() || of_move.ring.empty()) return std::nullopt;
  if (!of_region.ring.without(of_move.writes).empty() || !of_move.ring.without(of_region.writes).empty())
    return std::nullopt;
  // `skin` runs together with `move`, after the region's map of the same pass.
  if (skin) {
    const KernelAccess& of_skin = access_of(*skin);
    if (!of_skin.ring.empty() || must_wait(of_region, of_skin.reads(), of_skin.writes)) return std::nullopt;
  }
  return SweptSteps{skin, region, move};
}

}  // namespace fascicle::model
