// One pass over the body in place of two: whatever the cut, no vertex moves while a region that reads it is
// still to be done, and the bits are those of stage after stage.
#include "cpu_reference/sweeps.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "cpu_reference/cpu_solver.h"
#include "tests/support/bar_model.h"

namespace fascicle::tests {
namespace {

using cpu_reference::Range;
using cpu_reference::Simd;
using cpu_reference::slice_size;
using cpu_reference::Slices;
using cpu_reference::Sweep;
using model::Model;

// Stands in for the stages: notes which slices' regions are done, and complains where a vertex is moved too
// early or a map is taken that is not there.
struct Watch {
  const Model* model;
  std::vector<int> regions_done, moved;  // of each slice: how often
  std::vector<std::string> faults;
};
Watch* watch = nullptr;

void watch_region(const cpu_reference::LaneInput&, Range slices) {
  for (std::uint32_t s = slices.first; s < slices.last; ++s) {
    ++watch->regions_done[s];
    for (std::uint32_t i = s * slice_size; i < std::min((s + 1) * slice_size, watch->model->vertex_count);
         ++i)
      for (std::uint32_t e = watch->model->ring_offset[i]; e < watch->model->ring_offset[i + 1]; ++e)
        if (watch->moved[watch->model->ring[e] / slice_size] > 0)
          watch->faults.push_back("region " + std::to_string(i) + " reads a vertex that has moved");
  }
}

void watch_move(const cpu_reference::LaneInput&, Range slices) {
  for (std::uint32_t s = slices.first; s < slices.last; ++s) {
    ++watch->moved[s];
    for (std::uint32_t i = s * slice_size; i < std::min((s + 1) * slice_size, watch->model->vertex_count);
         ++i)
      for (std::uint32_t e = watch->model->ring_offset[i]; e < watch->model->ring_offset[i + 1]; ++e)
        if (watch->regions_done[watch->model->ring[e] / slice_size] == 0)
          watch->faults.push_back("vertex " + std::to_string(i) + " takes a map that is not there");
  }
}

constexpr cpu_reference::LaneStages watched{
    .skin = nullptr, .region = watch_region, .update = watch_move, .iterate = watch_move};

// Sweeps one after the other, those of `order` first to last.
Watch watched_run(const Model& model, const std::vector<Sweep>& sweeps, bool backwards,
                  bool shared_first = true) {
  const Slices slices = cpu_reference::make_slices(model);
  Watch result{&model, std::vector<int>(slices.count), std::vector<int>(slices.count), {}};
  watch = &result;
  cpu_reference::LaneInput in{};
  in.reach = slices.reach.data();
  if (shared_first)
    for (const Sweep& sweep : sweeps) cpu_reference::run_shared_regions(watched, in, sweep);
  for (std::size_t k = 0; k < sweeps.size(); ++k)
    cpu_reference::run_sweep(watched, watched.update, in, sweeps[backwards ? sweeps.size() - 1 - k : k]);
  watch = nullptr;
  return result;
}

TEST(Sweeps, DoEveryRegionOnceAndMoveNoVertexEarly) {
  const Model m = make_bar({.x = 150, .y = 5, .z = 4});
  const Slices slices = cpu_reference::make_slices(m);
  for (const unsigned threads : {1u, 2u, 5u})
    for (const bool backwards : {false, true}) {
      const std::vector<Sweep> sweeps = cpu_reference::make_sweeps(m, slices, threads, 0);
      ASSERT_GE(sweeps.size(), threads) << threads;
      const Watch run = watched_run(m, sweeps, backwards);
      EXPECT_TRUE(run.faults.empty()) << run.faults.front() << " of " << run.faults.size();
      EXPECT_EQ(run.regions_done, std::vector<int>(slices.count, 1));
      EXPECT_EQ(run.moved, std::vector<int>(slices.count, 1));
    }
}

// The check sees what it is there for: without the shared regions done first, maps are missing.
TEST(Sweeps, NeedTheirSharedRegionsFirst) {
  const Model m = make_bar({.x = 150, .y = 5, .z = 4});
  const std::vector<Sweep> sweeps = cpu_reference::make_sweeps(m, cpu_reference::make_slices(m), 2, 0);
  EXPECT_FALSE(watched_run(m, sweeps, false, false).faults.empty());
}

TEST(Sweeps, AreLeftOutWhereTheyWouldNotPay) {
  // Every region of a plate reaches far: no sweep of two has an inside.
  const Model plate = make_bar({.x = 2, .y = 40, .z = 40});
  EXPECT_TRUE(cpu_reference::make_sweeps(plate, cpu_reference::make_slices(plate), 2, 0).empty());
  const Model small = make_bar({.x = 150, .y = 5, .z = 4});
  EXPECT_TRUE(cpu_reference::make_sweeps(small, cpu_reference::make_slices(small), 2).empty());
}

TEST(Sweeps, OfALargeBodyKeepTheBits) {
  for (const bool implicit : {false, true}) {
    const Model m = make_bar({.x = 620, .y = 16, .z = 16, .muscle = true, .implicit = implicit});
    for (const unsigned threads : {1u, 3u})
      ASSERT_FALSE(cpu_reference::make_sweeps(m, cpu_reference::make_slices(m), threads).empty());
    const model::SolverOptions options{
        .integrator = implicit ? model::Integrator::implicit_step : model::Integrator::explicit_step,
        .iterations = 3};
    model::State first;
    for (const auto& [simd, threads] :
         {std::pair{Simd::scalar, 2u}, {Simd::automatic, 1u}, {Simd::automatic, 3u}}) {
      const auto solver = cpu_reference::make_cpu_solver(m, options, threads, simd);
      BarMotion motion(m, 2);
      solver->submit(motion.drive(1), {});
      solver->collect();
      model::State state = solver->save();
      if (first.positions.empty())
        first = std::move(state);
      else
        EXPECT_TRUE(first == state) << threads << " threads, " << (implicit ? "implicit" : "explicit");
    }
  }
}

}  // namespace
}  // namespace fascicle::tests
