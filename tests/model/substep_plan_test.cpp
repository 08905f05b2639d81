#include "host/model/substep_plan.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/bar_model.h"

namespace fascicle::tests {
namespace {

using model::Block;
using model::Field;
using model::Kernel;
using model::Model;

// For example "skin region update" or "predict | 20 (region iterate) | integrate": blocks with their
// repetitions.
std::string text_of(const model::SubstepPlan& plan) {
  std::string text;
  for (const Block& block : plan) {
    if (!text.empty()) text += " | ";
    std::string steps;
    for (const model::Step& step : block.steps)
      steps += (steps.empty() ? "" : " ") + std::string(name_of(step.kernel));
    text += block.repeat == Block::Repeat::once ? steps : std::to_string(block.times) + " (" + steps + ")";
  }
  return text;
}

std::string plan_of(const BarOptions& options, bool for_probe) {
  model::SolverOptions solver{.iterations = 7};
  if (options.implicit) solver.integrator = model::Integrator::implicit_step;
  return text_of(substep_plan(make_bar(options), solver, for_probe));
}

// The order of the method, written down a second time by hand.
TEST(SubstepPlan, HasTheStagesInTheirOrder) {
  EXPECT_EQ(plan_of({}, true), "predict region goal integrate");
  EXPECT_EQ(plan_of({}, false), "region update");
  EXPECT_EQ(plan_of({.skeleton = true}, true), "skin predict region goal integrate");
  EXPECT_EQ(plan_of({.skeleton = true}, false), "skin region update");
  EXPECT_EQ(plan_of({.skeleton = true, .ties = true}, true), "skin tie | predict region goal integrate");
  EXPECT_EQ(plan_of({.skeleton = true, .ties = true}, false), "skin tie | region update");
  EXPECT_EQ(plan_of({.skeleton = true, .ties = true, .implicit = true}, true),
            "skin tie predict | 7 (region goal relax) | integrate");
  EXPECT_EQ(plan_of({.skeleton = true, .implicit = true, .limits = true}, false),
            "skin predict | 7 (region iterate) | 12 (lack crowd limit) | integrate");
  const std::string search = "contact_bound contact_enclose contact_find contact_chain contact_crowd | ";
  const std::string respond = " | 2 (contact_press contact)", settle = " | contact_settle contact_rest";
  EXPECT_EQ(plan_of({.contact = true}, true), search + "predict region goal integrate" + respond);
  EXPECT_EQ(plan_of({.skeleton = true, .contact = true}, false), search + "skin region update" + respond);
  EXPECT_EQ(plan_of({.skeleton = true, .ties = true, .contact = true}, false),
            search + "skin tie | region update" + respond);
  EXPECT_EQ(
      plan_of({.ties = true, .implicit = true, .limits = true, .contact = true}, false),
      search +
          "tie predict | 7 (region iterate contact_hold contact_yield) | 12 (lack crowd limit) | integrate" +
          settle);
  EXPECT_EQ(plan_of({.implicit = true, .contact = true, .colliders = true}, true),
            search +
                "predict | 7 (region goal relax contact_hold contact_yield obstruct) | collide | integrate" +
                settle);
  EXPECT_EQ(plan_of({.colliders = true}, true), "predict region goal integrate | collide");
  EXPECT_EQ(plan_of({.skeleton = true, .colliders = true}, false), "skin region update | collide");
  EXPECT_EQ(plan_of({.ties = true, .contact = true, .colliders = true}, false),
            search + "tie | region update" + respond + " | collide");
  EXPECT_EQ(plan_of({.implicit = true, .colliders = true}, true),
            "predict | 7 (region goal relax obstruct) | collide | integrate");
  EXPECT_EQ(plan_of({.implicit = true, .limits = true, .colliders = true}, false),
            "predict | 7 (region iterate obstruct) | 12 (lack crowd limit) | collide | integrate");
}

// Every stage except embed is shown once per iteration; contact is shown in each, and again at the end of the
// substep.
TEST(SubstepPlan, ShowsAProbeEveryStage) {
  const Model m = make_bar(
      {.skeleton = true, .ties = true, .implicit = true, .limits = true, .contact = true, .colliders = true});
  std::vector<model::Stage> shown;
  for (const Block& block : substep_plan(m, {.integrator = model::Integrator::implicit_step}, true)) {
    for (const model::Step& step : block.steps)
      if (step.shown) shown.push_back(*step.shown);
    if (block.shown) shown.push_back(*block.shown);
  }
  std::vector<model::Stage> expected(model::all_stages.begin(), model::all_stages.end() - 1);
  const auto relax = std::find(expected.begin(), expected.end(), model::Stage::relax);
  ASSERT_NE(relax, expected.end());
  expected.insert(relax + 1, model::Stage::contact);
  EXPECT_EQ(shown, expected);
}

bool wait_for_each_other(Kernel a, Kernel b) {
  return must_wait(access_of(b), access_of(a).reads(), access_of(a).writes);
}

TEST(SubstepPlan, WaitsOnlyForWhatIsTouched) {
  EXPECT_FALSE(wait_for_each_other(Kernel::skin, Kernel::tie));
  EXPECT_TRUE(wait_for_each_other(Kernel::tie, Kernel::predict));
  EXPECT_TRUE(wait_for_each_other(Kernel::region, Kernel::update));
  EXPECT_TRUE(wait_for_each_other(Kernel::update, Kernel::region)) << "the next substep's";
  EXPECT_TRUE(wait_for_each_other(Kernel::region, Kernel::relax)) << "moves what region reads";
  // The buffers of skinned and skinned_before are swapped: the next substep's skin writes what update reads
  // as skinned_before.
  EXPECT_TRUE(must_wait(access_of(Kernel::skin), {Field::skinned_before}, {}));
  EXPECT_FALSE(wait_for_each_other(Kernel::skin, Kernel::contact_bound));
  const Kernel contact[] = {Kernel::contact_bound, Kernel::contact_enclose, Kernel::contact_find,
                            Kernel::contact_chain, Kernel::contact_crowd,   Kernel::contact_press,
                            Kernel::contact,       Kernel::contact_press};
  for (std::size_t k = 1; k < std::size(contact); ++k)
    EXPECT_TRUE(wait_for_each_other(contact[k - 1], contact[k])) << name_of(contact[k]);
  const Kernel held[] = {Kernel::contact_crowd, Kernel::contact_hold, Kernel::contact_yield,
                         Kernel::contact_hold};
  for (std::size_t k = 1; k < std::size(held); ++k)
    EXPECT_TRUE(wait_for_each_other(held[k - 1], held[k])) << name_of(held[k]);
  EXPECT_TRUE(wait_for_each_other(Kernel::iterate, Kernel::contact_hold)) << "reads the new positions";
  EXPECT_TRUE(wait_for_each_other(Kernel::contact_yield, Kernel::region)) << "the next iteration's";
  EXPECT_TRUE(wait_for_each_other(Kernel::contact_yield, Kernel::obstruct));
  EXPECT_TRUE(wait_for_each_other(Kernel::integrate, Kernel::contact_settle));
  EXPECT_TRUE(wait_for_each_other(Kernel::contact_settle, Kernel::contact_rest));
  EXPECT_TRUE(wait_for_each_other(Kernel::contact_rest, Kernel::predict)) << "the next substep's";
  EXPECT_TRUE(wait_for_each_other(Kernel::contact_find, Kernel::contact_press));
  EXPECT_TRUE(wait_for_each_other(Kernel::contact_bound, Kernel::update))
      << "moves the contents of the boxes";
  EXPECT_TRUE(wait_for_each_other(Kernel::update, Kernel::contact_press)) << "responds to the motion";
  EXPECT_TRUE(wait_for_each_other(Kernel::contact, Kernel::region)) << "the next substep's";
  EXPECT_FALSE(must_wait(access_of(Kernel::embed), {Field::position}, {Field::velocity}));
  EXPECT_TRUE(wait_for_each_other(Kernel::update, Kernel::collide));
  EXPECT_TRUE(wait_for_each_other(Kernel::collide, Kernel::region)) << "the next substep's";
  EXPECT_TRUE(wait_for_each_other(Kernel::iterate, Kernel::obstruct));
  EXPECT_TRUE(wait_for_each_other(Kernel::obstruct, Kernel::lack));
  EXPECT_TRUE(wait_for_each_other(Kernel::collide, Kernel::integrate)) << "an implicit substep's";
}

// Fused kernels give the same bits only if the reordering breaks no dependency: predict moves past region
// into update.
TEST(SubstepPlan, FusesOnlyWhatMayChangePlaces) {
  EXPECT_FALSE(access_of(Kernel::region).reads().has(Field::velocity));
  EXPECT_FALSE(access_of(Kernel::region).writes.has(Field::velocity));
  // As in an explicit substep, where predict writes only velocities.
  const model::KernelAccess predict{
      Kernel::predict,  "predict", model::KernelItems::vertices, access_of(Kernel::predict).own, {}, {},
      {Field::velocity}};
  const model::KernelAccess& region = access_of(Kernel::region);
  EXPECT_FALSE(must_wait(region, {Field::velocity, Field::gravity, Field::tied}, predict.writes));
  EXPECT_FALSE(must_wait(predict, {}, region.writes));
}

TEST(SubstepPlan, SweepsBlocksThatReachOneRing) {
  const auto swept = [](const BarOptions& options, std::size_t block) {
    model::SolverOptions solver;
    if (options.implicit) solver.integrator = model::Integrator::implicit_step;
    return model::swept_steps(substep_plan(make_bar(options), solver, false).at(block));
  };
  const auto whole = swept({.skeleton = true}, 0);
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->skin, Kernel::skin);
  EXPECT_EQ(whole->region, Kernel::region);
  EXPECT_EQ(whole->move, Kernel::update);
  const auto iterations = swept({.implicit = true}, 1);
  ASSERT_TRUE(iterations);
  EXPECT_FALSE(iterations->skin);
  EXPECT_EQ(iterations->move, Kernel::iterate);
  // Ties reach across the body, and limits run over tetrahedra.
  EXPECT_FALSE(swept({.skeleton = true, .ties = true}, 0));
  EXPECT_TRUE(swept({.skeleton = true, .ties = true}, 1));
  EXPECT_FALSE(swept({.contact = true}, 0));
  EXPECT_TRUE(swept({.contact = true}, 1));
  EXPECT_FALSE(swept({.implicit = true, .limits = true}, 2));
  // A block that ends with solids has one step more than a sweep can run.
  EXPECT_TRUE(swept({.colliders = true}, 0));
  EXPECT_FALSE(swept({.colliders = true}, 1));
  EXPECT_FALSE(swept({.implicit = true, .colliders = true}, 1));
  EXPECT_FALSE(swept({.skeleton = true, .implicit = true}, 0)) << "skin and predict do not read the one-ring";
  EXPECT_FALSE(model::swept_steps({.steps = {{Kernel::predict}, {Kernel::region}, {Kernel::goal}}}));
}

}  // namespace
}  // namespace fascicle::tests
