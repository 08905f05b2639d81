// Each barrier that a solver records is left out alone, and someone must notice: the validation layer, which
// looks across submissions here too, or where it does not look, WatchedCommands.
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
    // The layer takes these from the environment alone. It says the same ten times at most unless told.
    setenv("VK_LAYER_ENABLES", "VALIDATION_CHECK_ENABLE_SYNCHRONIZATION_VALIDATION_QUEUE_SUBMIT", 1);
    setenv("VK_LAYER_DUPLICATE_MESSAGE_LIMIT", "1000000000", 1);
    ValidatedTest::SetUp();
  }
  void TearDown() override {
    unsetenv("VK_LAYER_ENABLES");
    unsetenv("VK_LAYER_DUPLICATE_MESSAGE_LIMIT");
  }
};

// A solver and what can be asked of it.
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
    solver = gpu::make_experimental_solver(*device, model, options, {.limits = limits});
  }
  // Frame k of the motion, whatever came before.
  void submit(std::uint64_t k, model::Read what = all_results, bool with_probe = false) {
    BarMotion motion(model, 2, has_cuts);
    Unheard probe;
    solver->submit(motion.drive(k), what, with_probe ? &probe : nullptr);
  }

  WatchedCommands watched;  // first: the device is opened under its eyes
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

// Those between dispatches that only WatchedCommands misses: the layer takes two writes of one buffer for
// writes of different places, does not see that a shader that writes a buffer reads it too, and does not know
// that the host reads.
const std::set<std::string> unseen_by_layer{"contact | collide", "contact_yield | obstruct",
                                            "limit | collide", "copy to the host | "};

// Those that no one misses: the schedule counts the two buffers of skinned places as one, of which rebase
// moves one and skin writes the other. Where a frame is not cut here, this is the barrier before region.
const std::set<std::string> spare{"rebase | skin"};

// Submissions begin with a barrier, whatever they do. It must be missed in one of those that begin alike.
std::string kind_of(const WatchedBarrier& opening) {
  return opening.after + " | " + (opening.before.starts_with("copy") ? opening.before : "dispatch");
}

TEST_F(Barriers, LeftOutAloneAreEachMissed) {
  std::size_t tried = 0;
  std::set<std::string> dispatched, unseen;
  std::map<std::string, bool> openings;  // of each kind, whether one was missed
  for (const Body& body : bodies) {
    Trial trial(*index, body);
    // What is seen while an action runs without the barrier, and a frame after it; then all is waited for.
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
      run(action, std::nullopt);  // the first frame of a solver has more to write
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
            << where << label << "a barrier that nothing follows";
        const bool is_opening = label.starts_with("start");
        const std::string kind = kind_of(barriers[k]);
        // Those to the host are recorded in several places.
        if (is_opening ? openings[kind]
                       : !known.insert(barriers[k].is_to_host ? action.name + label : label).second)
          continue;
        if (is_opening && !known.insert(action.name + label).second) continue;
        run(action, k);
        ASSERT_EQ(trial.watched.barriers()[k].label(), label);
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
