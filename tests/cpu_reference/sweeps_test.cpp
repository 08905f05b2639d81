// Several passes over the body in one: whatever the cut, each reads what the pass before left and nothing
// else, and the bits are those of stage after stage.
#include "cpu_reference/sweeps.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "cpu_reference/cpu_solver.h"
#include "tests/support/bar_model.h"

namespace fascicle::tests {
namespace {

using cpu_reference::Part;
using cpu_reference::Pass;
using cpu_reference::Range;
using cpu_reference::Simd;
using cpu_reference::slice_size;
using cpu_reference::Slices;
using cpu_reference::Sweep;
using cpu_reference::Sweeps;
using model::Model;

// Stands in for the stages: notes by how many passes each slice's regions are done and its vertices moved,
// and complains of what comes too early or too late.
struct Watch {
  const Model* model;
  std::vector<std::uint32_t> regions, vertices;  // of each slice: passes done
  std::vector<std::uint32_t> skins;
  std::vector<std::string> faults;

  // That slices of the range have `before` passes behind them in `done`, as have those of their one-rings in
  // `read`.
  void expect(const char* what, Range slices, const std::vector<std::uint32_t>& done, std::uint32_t before,
              const std::vector<std::uint32_t>& read, std::uint32_t read_passes) {
    const auto complain = [&](std::uint32_t i, const std::string& fault) {
      faults.push_back(std::string(what) + " " + std::to_string(i) + " of pass " + std::to_string(before) +
                       fault);
    };
    for (std::uint32_t i = slices.first * slice_size;
         i < std::min(slices.last * slice_size, model->vertex_count); ++i) {
      if (done[i / slice_size] != before) complain(i, ": done before");
      for (std::uint32_t e = model->ring_offset[i]; e < model->ring_offset[i + 1]; ++e)
        if (read[model->ring[e] / slice_size] != read_passes)
          complain(i, " reads " + std::to_string(model->ring[e]) + " after " +
                          std::to_string(read[model->ring[e] / slice_size]) + " passes");
    }
  }
};
Watch* watch = nullptr;

// Which pass a stage is of.
std::uint32_t pass_of(const cpu_reference::LaneInput& in) {
  return in.step.first_bone;
}

void watch_region(const cpu_reference::LaneInput& in, Range slices) {
  const std::uint32_t pass = pass_of(in);
  watch->expect("region", slices, watch->regions, pass, watch->vertices, pass);
  for (std::uint32_t s = slices.first; s < slices.last; ++s) ++watch->regions[s];
}

// Of skinned positions two passes are kept: the older goes once its vertices have moved.
void watch_skin(const cpu_reference::LaneInput& in, Range slices) {
  for (std::uint32_t s = slices.first; s < slices.last; ++s)
    if (watch->skins[s]++ != pass_of(in) || watch->vertices[s] != pass_of(in))
      watch->faults.push_back("slice " + std::to_string(s) + " is skinned at the wrong time");
}

void watch_move(const cpu_reference::LaneInput& in, Range slices) {
  const std::uint32_t pass = pass_of(in);
  watch->expect("vertex", slices, watch->vertices, pass, watch->regions, pass + 1);
  for (std::uint32_t s = slices.first; s < slices.last; ++s) {
    if (watch->skins[s] != pass + 1) watch->faults.push_back("slice " + std::to_string(s) + " has no skin");
    ++watch->vertices[s];
  }
}

enum class Order { forwards, backwards, joints_first };

Watch watched_run(const Model& model, const Sweeps& sweeps, std::uint32_t count, Order order) {
  const Slices slices = cpu_reference::make_slices(model);
  const std::vector<std::uint32_t> none(slices.count, 0);
  Watch result{&model, none, none, none, {}};
  std::vector<Pass> passes;
  for (std::uint32_t p = 0; p < count; ++p) {
    passes.push_back({.in = {}, .skin = watch_skin, .region = watch_region, .move = watch_move});
    passes.back().in.reach = slices.reach.data();
    passes.back().in.step.first_bone = p;
  }
  watch = &result;
  const auto run_tiles = [&] {
    std::vector<Sweep> tiles = sweeps.tiles;
    if (order == Order::backwards) std::reverse(tiles.begin(), tiles.end());
    for (const Sweep& tile : tiles) cpu_reference::run_tile(tile, passes);
  };
  // By threes, as threads would share them.
  const auto run_all_joints = [&](std::size_t p, Range Part::*which, cpu_reference::LaneStage stage) {
    const std::uint32_t all = cpu_reference::slices_of_joints(sweeps, p, which);
    for (std::uint32_t first = 0; first < all; first += 3)
      cpu_reference::run_joints(sweeps, p, which, {first, std::min(first + 3, all)}, stage, passes[p].in);
  };
  if (order != Order::joints_first) run_tiles();
  for (std::size_t p = 0; p < passes.size(); ++p) {
    run_all_joints(p, &Part::regions, watch_region);
    run_all_joints(p, &Part::vertices, watch_skin);
    run_all_joints(p, &Part::vertices, watch_move);
  }
  if (order == Order::joints_first) run_tiles();
  watch = nullptr;
  return result;
}

// Tiles run at the same time: none may read or write what another writes. Each sees exactly what the pass
// before left, whether all that stand before it are done or all that stand behind it.
TEST(Sweeps, DoEveryPassOnceAndReadOnlyThePassBefore) {
  const Model m = make_bar({.x = 700, .y = 5, .z = 4});
  const Slices slices = cpu_reference::make_slices(m);
  for (const unsigned threads : {1u, 2u, 5u}) {
    const Sweeps sweeps = cpu_reference::make_sweeps(m, slices, threads, 0);
    ASSERT_GE(sweeps.tiles.size(), threads);
    ASSERT_EQ(sweeps.joints.size(), sweeps.tiles.size() - 1);
    ASSERT_EQ(sweeps.most_passes(), cpu_reference::most_passes) << threads;
    for (std::uint32_t passes = 1; passes <= sweeps.most_passes(); ++passes)
      for (const Order order : {Order::forwards, Order::backwards}) {
        SCOPED_TRACE(std::to_string(passes) + " passes of " + std::to_string(threads) + " threads");
        const Watch run = watched_run(m, sweeps, passes, order);
        EXPECT_TRUE(run.faults.empty()) << run.faults.front() << ", of " << run.faults.size();
        const std::vector<std::uint32_t> all(slices.count, passes);
        EXPECT_EQ(run.regions, all);
        EXPECT_EQ(run.vertices, all);
        EXPECT_EQ(run.skins, all);
      }
  }
}

// The check sees what it is there for.
TEST(Sweeps, NeedTheirTilesFirst) {
  const Model m = make_bar({.x = 700, .y = 5, .z = 4});
  const Sweeps sweeps = cpu_reference::make_sweeps(m, cpu_reference::make_slices(m), 2, 0);
  EXPECT_FALSE(watched_run(m, sweeps, 2, Order::joints_first).faults.empty());
}

// And it would see a tile that goes one slice too far.
TEST(Sweeps, AreAsWideAsTheyMayBe) {
  const Model m = make_bar({.x = 700, .y = 5, .z = 4});
  Sweeps sweeps = cpu_reference::make_sweeps(m, cpu_reference::make_slices(m), 2, 0);
  ++sweeps.tiles.front().front().vertices.last;
  ++sweeps.joints.front().front().vertices.first;
  EXPECT_FALSE(watched_run(m, sweeps, 1, Order::forwards).faults.empty());
}

TEST(Sweeps, AreLeftOutWhereTheyWouldNotPay) {
  // Every region of a plate reaches far: no tile of two has an inside.
  const Model plate = make_bar({.x = 2, .y = 40, .z = 40});
  EXPECT_TRUE(cpu_reference::make_sweeps(plate, cpu_reference::make_slices(plate), 2, 0).empty());
  const Model small = make_bar({.x = 150, .y = 5, .z = 4});
  EXPECT_TRUE(cpu_reference::make_sweeps(small, cpu_reference::make_slices(small), 2).empty());
}

// What is between the first pass and the last would not stay in a cache.
TEST(Sweeps, TakeFewerPassesOfBodiesThatAreThick) {
  const Model thick = make_bar({.x = 40, .y = 90, .z = 90});
  const Slices slices = cpu_reference::make_slices(thick);
  const std::uint32_t one = cpu_reference::make_sweeps(thick, slices, 1).most_passes();
  const std::uint32_t two = cpu_reference::make_sweeps(thick, slices, 2).most_passes();
  EXPECT_LT(one, cpu_reference::most_passes);
  EXPECT_LT(two, one);
  EXPECT_GE(two, 1u);
}

// A whole sweep and what is left, and with cuts less.
TEST(Sweeps, OfALargeBodyKeepTheBits) {
  struct Case {
    const char* name;
    BarOptions bar;
    std::uint32_t substeps;
  };
  const BarOptions large{.x = 220, .y = 16, .z = 16, .surface = false};
  BarOptions posed = large, soft = large;
  posed.skeleton = posed.carried = posed.cuts = posed.muscle = posed.forces = true;
  soft.implicit = soft.muscle = true;
  for (const Case& c : {Case{"explicit", posed, 10}, Case{"implicit", soft, 2}}) {
    const Model m = make_bar(c.bar);
    for (const unsigned threads : {1u, 3u})
      ASSERT_GT(cpu_reference::make_sweeps(m, cpu_reference::make_slices(m), threads).most_passes(), 2u);
    const model::SolverOptions options{
        .integrator = c.bar.implicit ? model::Integrator::implicit_step : model::Integrator::explicit_step,
        .iterations = 10};
    model::State first;
    for (const auto& [simd, threads] :
         {std::pair{Simd::scalar, 2u}, {Simd::automatic, 1u}, {Simd::automatic, 3u}}) {
      const auto solver = cpu_reference::make_cpu_solver(m, options, threads, simd);
      BarMotion motion(m, c.substeps, c.bar.cuts);
      for (std::uint64_t frame = 1; frame <= 3; ++frame) {
        solver->submit(motion.drive(frame), {});
        solver->collect();
      }
      model::State state = solver->save();
      if (first.positions.empty())
        first = std::move(state);
      else
        EXPECT_TRUE(first == state) << threads << " threads, " << c.name;
    }
  }
}

}  // namespace
}  // namespace fascicle::tests
