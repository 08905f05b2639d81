// Omits each recorded barrier in turn. Each omission must be detected by the validation layer, here with
// checks across submissions, or, in the layer's blind spots, by WatchedCommands.
#include <algorithm>
#include <cstdlib>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "gpu/experiments.h"
#include "tests/gpu/validated.h"
#include "tests/gpu/watched_commands.h"
#include "tests/support/bar_model.h"

namespace fascicle::tests {
namespace {

struct Unheard : model::Probe {
  void on_stage(const model::Where&, std::span<const float>) override {}
};

constexpr model::Read all_results{.positions = true, .velocities = true, .surface = true, .skinned = true};

struct Body {
  const char* name;
  BarOptions bar;
  gpu::SubmissionLimits limits = {};
};

// Every stage and every kernel runs in one of the first two.
const Body bodies[] = {
    {"explicit",
     {.skeleton = true,
      .carried = true,
      .cuts = true,
      .muscle = true,
      .forces = true,
      .volume = true,
      .ties = true,
      .contact = true,
      .colliders = true,
      .odd_vertices = true}},
    {"implicit",
     {.skeleton = true,
      .carried = true,
      .cuts = true,
      .muscle = true,
      .forces = true,
      .volume = true,
      .ties = true,
      .implicit = true,
      .limits = true,
      .contact = true,
      .ignored_contact = true,
      .colliders = true}},
    {"cut into submissions", {.skeleton = true, .ties = true}, {.slices_per_submission = 3}},
};

class Barriers : public ValidatedTest {
 protected:
  void SetUp() override {
    // The layer reads these only from the environment. By default it reports a duplicate at most ten times.
    setenv("VK_LAYER_ENABLES", "VALIDATION_CHECK_ENABLE_SYNCHRONIZATION_VALIDATION_QUEUE_SUBMIT", 1);
    setenv("VK_LAYER_DUPLICATE_MESSAGE_LIMIT", "1000000000", 1);
    ValidatedTest::SetUp();
  }
  void TearDown() override {
    unsetenv("VK_LAYER_ENABLES");
    unsetenv("VK_LAYER_DUPLICATE_MESSAGE_LIMIT");
  }
};

// A solver with its device, messages and recorded commands.
struct Trial {
  Trial(std::uint32_t device_index, const Body& of)
      : model(make_bar(of.bar)),
        options{.integrator =
                    of.bar.implicit ? model::Integrator::implicit_step : model::Integrator::explicit_step,
                .iterations = 3},
        limits(of.limits),
        has_cuts(of.bar.cuts) {
    gpu::DeviceOptions device_options;
    device_options.validation = true;
    device_options.on_validation_message = [this](const std::string& text) { messages.push_back(text); };
    device = std::make_unique<gpu::Device>(device_index, device_options);
    make();
    rest = solver->save();
  }

  void make() {
    solver.reset();
    watched.expect_solver();
    solver = gpu::make_experimental_solver(*device, model, options, {.limits = limits, .keep_pace = true});
  }
  // Frame k of the motion, independent of earlier frames.
  void submit(std::uint64_t k, model::Read what = all_results, bool with_probe = false) {
    BarMotion motion(model, 2, has_cuts);
    Unheard probe;
    solver->submit(motion.drive(k), what, with_probe ? &probe : nullptr);
  }

  WatchedCommands watched;  // first, to watch the device being opened
  std::vector<std::string> messages;
  model::Model model;
  model::SolverOptions options;
  gpu::SubmissionLimits limits;
  bool has_cuts;
  std::unique_ptr<gpu::Device> device;
  std::unique_ptr<model::Solver> solver;
  model::State rest;
};

struct Action {
  const char* name;
  void (*prepare)(Trial&);
  void (*run)(Trial&);
};
void nothing(Trial&) {}

// Frame 2 moves the origin, frame 3 has a cut.
const Action actions[] = {
    {"two frames at once", nothing,
     [](Trial& t) {
       t.submit(2);
       t.submit(2);
     }},
    {"a frame with a cut", nothing, [](Trial& t) { t.submit(3); }},
    {"a frame with a probe", nothing, [](Trial& t) { t.submit(2, all_results, true); }},
    {"save", [](Trial& t) { t.submit(2, {}); }, [](Trial& t) { t.solver->save(); }},
    {"save after a wait",
     [](Trial& t) {
       t.submit(2, {});
       t.solver->collect();
     },
     [](Trial& t) { t.solver->save(); }},
    {"load", [](Trial& t) { t.submit(2, {}); }, [](Trial& t) { t.solver->load(t.rest); }},
    {"make a solver", nothing, [](Trial& t) { t.make(); }},
};

// Barriers between dispatches whose omission only WatchedCommands detects: the layer assumes that two writes
// to one buffer go to different places, ignores that a shader that writes a buffer may also read it, and does
// not know about reads by the host.
const std::set<std::string> unseen_by_layer{"contact | collide", "contact_yield | obstruct",
                                            "limit | collide", "copy to the host | "};

// Barriers whose omission nothing detects: the schedule treats the two buffers of skinned positions as one,
// but rebase moves one and skin writes the other. In frames without a cut, this is the barrier before region.
const std::set<std::string> spare{"rebase | skin"};

// Every submission begins with a barrier. Its omission must be detected in at least one submission of each
// kind.
std::string kind_of(const WatchedBarrier& opening) {
  return opening.after + " | " + (opening.before.starts_with("copy") ? opening.before : "dispatch");
}

TEST_F(Barriers, LeftOutAloneAreEachMissed) {
  std::size_t tried = 0;
  std::set<std::string> dispatched, unseen;
  std::map<std::string, bool> openings;  // of each kind, whether one was missed
  for (const Body& body : bodies) {
    Trial trial(*index, body);
    // Records what is detected during an action without the barrier and the frame after it; then waits.
    const auto run = [&](const Action& action, std::optional<std::size_t> left_out) {
      action.prepare(trial);
      trial.messages.clear();
      trial.watched.start(left_out);
      action.run(trial);
      const std::size_t barriers = trial.watched.barriers().size();
      trial.submit(2);
      trial.solver->save();
      trial.solver->load(trial.rest);
      return barriers;
    };
    std::set<std::string> known;
    for (const Action& action : actions) {
      const std::string where = std::string(body.name) + ", " + action.name + ": ";
      run(action, std::nullopt);  // the first frame of a solver writes more
      const std::size_t count = run(action, std::nullopt);
      for (const std::string& message : trial.messages) ADD_FAILURE() << where << message;
      for (const std::string& hazard : trial.watched.hazards()) ADD_FAILURE() << where << hazard;
      const std::vector<WatchedBarrier> barriers(
          trial.watched.barriers().begin(),
          trial.watched.barriers().begin() + static_cast<std::ptrdiff_t>(count));
      for (std::size_t k = 0; k < count; ++k) {
        const std::string label = barriers[k].label();
        EXPECT_FALSE(barriers[k].after.empty()) << where << "two barriers in a row";
        EXPECT_FALSE(barriers[k].before.empty() && !barriers[k].is_to_host)
            << where << label << "a barrier with nothing after it";
        const bool is_opening = label.starts_with("start");
        const std::string kind = kind_of(barriers[k]);
        // Barriers to the host are recorded in several places.
        if (is_opening ? openings[kind]
                       : !known.insert(barriers[k].is_to_host ? action.name + label : label).second)
          continue;
        if (is_opening && !known.insert(action.name + label).second) continue;
        run(action, k);
        ASSERT_LT(k, trial.watched.barriers().size()) << where << label;
        ASSERT_EQ(trial.watched.barriers()[k].label(), label) << where;
        ++tried;
        const bool layer = std::any_of(
            trial.messages.begin(), trial.messages.end(),
            [](const std::string& message) { return message.find("SYNC-HAZARD") != std::string::npos; });
        const bool is_missed = layer || !trial.watched.hazards().empty();
        if (is_opening) {
          openings[kind] = is_missed;
          continue;
        }
        EXPECT_EQ(is_missed, !spare.contains(label)) << where << label;
        if (is_missed && !layer) unseen.insert(label);
      }
    }
    dispatched.insert(trial.watched.dispatched().begin(), trial.watched.dispatched().end());
  }
  for (const auto& [kind, is_missed] : openings) EXPECT_TRUE(is_missed) << kind;
  EXPECT_EQ(openings.size(), 7u);
  EXPECT_EQ(unseen, unseen_by_layer);
  EXPECT_EQ(dispatched.size(), model::kernel_count);
  EXPECT_GT(tried, 60u);  // 83 with the layer of Debian 12
}

}  // namespace
}  // namespace fascicle::tests
