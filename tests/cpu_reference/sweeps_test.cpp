// Several passes over the body in one sweep: for any partition, each pass reads only what the previous pass
// wrote, and the bits are those of running stage after stage.
#include "cpu_reference/solver/sweeps.h"

#include <algorithm>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "cpu_reference/solver/cpu_solver.h"
#include "tests/support/bar_model.h"
#include "tests/support/contact_models.h"

namespace fascicle::tests {
namespace {

using cpu_reference::Part;
using cpu_reference::Parts;
using cpu_reference::Pass;
using cpu_reference::Range;
using cpu_reference::Simd;
using cpu_reference::slice_size;
using cpu_reference::Slices;
using cpu_reference::Sweeps;
using model::Model;

// Replaces the stages: counts the passes done for each slice's regions and vertices, and reports what runs
// too early or too late.
struct Watch {
  const Model* model;
  std::vector<std::uint32_t> regions, vertices;  // passes done, per slice
  std::vector<std::uint32_t> skins;
  std::vector<std::string> faults;

  // Checks that slices of the range have done `before` passes, and that they and their one-rings have done
  // `read_passes` in `read`.
  void expect(const char* what, Range slices, const std::vector<std::uint32_t>& done, std::uint32_t before,
              const std::vector<std::uint32_t>& read, std::uint32_t read_passes) {
    const auto complain = [&](std::uint32_t i, const std::string& fault) {
      faults.push_back(std::string(what) + " " + std::to_string(i) + " of pass " + std::to_string(before) +
                       fault);
    };
    for (std::uint32_t i = slices.first * slice_size;
         i < std::min(slices.last * slice_size, model->vertex_count); ++i) {
      if (done[i / slice_size] != before) complain(i, ": done before");
      if (read[i / slice_size] != read_passes) complain(i, " reads its own too early or late");
      for (std::uint32_t e = model->ring_offset[i]; e < model->ring_offset[i + 1]; ++e)
        if (read[model->ring[e] / slice_size] != read_passes)
          complain(i, " reads " + std::to_string(model->ring[e]) + " after " +
                          std::to_string(read[model->ring[e] / slice_size]) + " passes");
    }
  }
};
Watch* watch = nullptr;

// The pass that a stage belongs to.
std::uint32_t pass_of(const cpu_reference::LaneInput& in) {
  return in.step.first_bone;
}

void watch_region(const cpu_reference::LaneInput& in, Range slices) {
  const std::uint32_t pass = pass_of(in);
  watch->expect("region", slices, watch->regions, pass, watch->vertices, pass);
  for (std::uint32_t s = slices.first; s < slices.last; ++s) ++watch->regions[s];
}

// Skinned positions of two passes are kept: the older one is reused once its vertices have moved.
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
    std::vector<Parts> tiles = sweeps.tiles;
    if (order == Order::backwards) std::reverse(tiles.begin(), tiles.end());
    for (const Parts& tile : tiles) cpu_reference::run_tile(tile, passes);
  };
  // In groups of three, as if shared by threads.
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

// Changes only numbers: vertex k becomes new_number[k]. Covers only what the replacement stages read.
Model renumbered(const Model& m, const std::vector<std::uint32_t>& new_number) {
  Model r = m;
  std::vector<std::uint32_t> old_number(m.vertex_count);
  for (std::uint32_t k = 0; k < m.vertex_count; ++k) old_number[new_number[k]] = k;
  r.ring.clear();
  for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
    const std::uint32_t k = old_number[i];
    std::vector<std::uint32_t> ring;
    for (std::uint32_t e = m.ring_offset[k]; e < m.ring_offset[k + 1]; ++e)
      ring.push_back(new_number[m.ring[e]]);
    std::sort(ring.begin(), ring.end());
    r.ring.insert(r.ring.end(), ring.begin(), ring.end());
    r.ring_offset[i + 1] = static_cast<std::uint32_t>(r.ring.size());
  }
  return r;
}

// Neighbours at irregular distances, so that the slices' reaches do not ascend by themselves.
Model shuffled_bar() {
  const Model m = make_bar({.x = 700, .y = 5, .z = 4, .odd_vertices = true});
  std::vector<std::uint32_t> number(m.vertex_count);
  std::iota(number.begin(), number.end(), 0u);
  std::mt19937 random(1);
  for (std::uint32_t k = 0; k + 200 < m.vertex_count; k += 1 + static_cast<std::uint32_t>(random() % 100))
    std::swap(number[k], number[k + static_cast<std::uint32_t>(random() % 200)]);
  return renumbered(m, number);
}

// Tiles run concurrently, so none may read or write what another writes. Each sees exactly the output of the
// previous pass, whether all tiles before it are done or all tiles after it.
TEST(Sweeps, DoEveryPassOnceAndReadOnlyThePassBefore) {
  for (const bool shuffled : {false, true}) {
    const Model m = shuffled ? shuffled_bar() : make_bar({.x = 700, .y = 5, .z = 4});
    const Slices slices = cpu_reference::make_slices(m);
    for (const unsigned threads : {1u, 2u, 5u, 16u}) {
      if (shuffled && threads == 16) continue;
      const Sweeps sweeps = cpu_reference::make_sweeps(m, slices, threads, 0);
      ASSERT_GE(sweeps.tiles.size(), threads);
      ASSERT_EQ(sweeps.joints.size(), sweeps.tiles.size() - 1);
      ASSERT_GE(sweeps.passes(), threads == 1 ? cpu_reference::most_swept_passes : threads == 2 ? 2u : 1u);
      for (std::uint32_t passes = 1; passes <= sweeps.passes(); ++passes)
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
}

// Threads wait for each other after the tiles, so tiles must contain about the same amount of work.
TEST(Sweeps, GiveTilesTheSameToDo) {
  const Model m = make_bar({.x = 700, .y = 5, .z = 4});
  const Slices slices = cpu_reference::make_slices(m);
  for (const unsigned threads : {2u, 4u, 7u}) {
    std::vector<std::uint32_t> work;
    for (const Parts& tile : cpu_reference::make_sweeps(m, slices, threads, 0).tiles) {
      work.push_back(0);
      for (const Part& part : tile) work.back() += part.vertices.last - part.vertices.first;
    }
    ASSERT_GE(work.size(), threads);
    const auto [least, most] = std::minmax_element(work.begin(), work.end());
    EXPECT_LT(*most, 1.15 * *least) << threads;
  }
}

// The control: joints before their tiles are detected.
TEST(Sweeps, NeedTheirTilesFirst) {
  const Model m = make_bar({.x = 700, .y = 5, .z = 4});
  const Sweeps sweeps = cpu_reference::make_sweeps(m, cpu_reference::make_slices(m), 2, 0);
  EXPECT_FALSE(watched_run(m, sweeps, 2, Order::joints_first).faults.empty());
}

// The control: a tile that is one slice too wide is detected, in any pass and at either end.
TEST(Sweeps, AreAsWideAsTheyMayBe) {
  const Model m = make_bar({.x = 700, .y = 5, .z = 4});
  const Sweeps sweeps = cpu_reference::make_sweeps(m, cpu_reference::make_slices(m), 2, 0);
  ASSERT_GE(sweeps.passes(), 2u);
  for (std::size_t p = 0; p < sweeps.passes(); ++p)
    for (Range Part::*which : {&Part::regions, &Part::vertices})
      for (const bool back : {false, true}) {
        // Regions of the first pass read across the cut what no tile moves.
        if (p == 0 && which == &Part::regions) continue;
        Sweeps wide = sweeps;
        if (back) {
          ++(wide.tiles[0][p].*which).last;
          ++(wide.joints[0][p].*which).first;
        } else {
          --(wide.tiles[1][p].*which).first;
          --(wide.joints[0][p].*which).last;
        }
        const auto faults = [&](Order order) {
          return watched_run(m, wide, sweeps.passes(), order).faults.size();
        };
        EXPECT_GT(faults(Order::forwards) + faults(Order::backwards), 0u)
            << "pass " << p << (back ? ", back" : ", front");
      }
}

TEST(Sweeps, AreLeftOutWhereTheyWouldNotPay) {
  // Every region of a plate reaches far, so neither of two tiles has an interior. Tiles of a short bar have
  // too little.
  const Model plate = make_bar({.x = 2, .y = 40, .z = 40});
  EXPECT_TRUE(cpu_reference::make_sweeps(plate, cpu_reference::make_slices(plate), 2, 0).empty());
  const Model bar = make_bar({.x = 150, .y = 5, .z = 4});
  EXPECT_TRUE(cpu_reference::make_sweeps(bar, cpu_reference::make_slices(bar), 40, 0).empty());
  // Small bodies stay in caches anyway.
  EXPECT_TRUE(cpu_reference::make_sweeps(bar, cpu_reference::make_slices(bar), 2).empty());
}

// Bars from too short to long enough: where there are sweeps, their tiles cover at least half of all passes.
TEST(Sweeps, CoverAtLeastHalfOfWhatIsDone) {
  std::uint32_t left_out = 0, made = 0;
  for (std::uint32_t x = 40; x <= 600; x += 40) {
    const Model bar = make_bar({.x = x, .y = 5, .z = 4});
    const Slices slices = cpu_reference::make_slices(bar);
    const Sweeps sweeps = cpu_reference::make_sweeps(bar, slices, 20, 0);
    if (sweeps.empty()) {
      ++left_out;
      continue;
    }
    ++made;
    std::uint64_t inside = 0;
    for (const Parts& tile : sweeps.tiles)
      for (const Part& part : tile) inside += part.vertices.last - part.vertices.first;
    EXPECT_GE(2 * inside, std::uint64_t{sweeps.passes()} * slices.count) << x;
  }
  EXPECT_GT(left_out, 0u);
  EXPECT_GT(made, 0u);
}

// What is between the first and the last pass would not fit in a cache.
TEST(Sweeps, TakeFewerPassesOfBodiesThatAreThick) {
  const Model thick = make_bar({.x = 8, .y = 120, .z = 60});
  const Slices slices = cpu_reference::make_slices(thick);
  const std::uint32_t one = cpu_reference::make_sweeps(thick, slices, 1).passes();
  const std::uint32_t two = cpu_reference::make_sweeps(thick, slices, 2).passes();
  EXPECT_LT(one, cpu_reference::most_swept_passes);
  EXPECT_LT(two, one);
  EXPECT_GE(two, 1u);
}

// Whole sweeps and remainders, shorter ones at cuts, a frame with a probe in between, and a resumed run.
TEST(Sweeps, OfALargeBodyKeepTheBits) {
  struct Case {
    const char* name;
    BarOptions bar;
    std::uint32_t substeps;
  };
  const BarOptions large{.x = 220, .y = 16, .z = 16, .surface = false};
  BarOptions posed = large, tied = large, touching = large, held = large, soft = large;
  posed.skeleton = posed.carried = posed.cuts = posed.muscle = posed.forces = posed.volume = true;
  tied.ties = true;
  touching.contact = touching.skeleton = true;
  held.colliders = true;
  soft.implicit = soft.muscle = soft.skeleton = soft.carried = true;
  struct Nobody : model::Probe {
    void on_stage(const model::Where&, std::span<const float>) override {}
  };
  for (const Case& c : {Case{"explicit", posed, 10}, Case{"ties", tied, 3}, Case{"contact", touching, 2},
                        Case{"colliders", held, 3}, Case{"implicit", soft, 2}}) {
    Model m = make_bar(c.bar);
    if (m.has_contact()) {
      // Only those at one end, so that the search takes less time than the rest.
      m.contact_tetrahedron.resize(4 * std::size_t{600});
      finish_contact(m);
    }
    for (const unsigned threads : {1u, 3u})
      ASSERT_GT(cpu_reference::make_sweeps(m, cpu_reference::make_slices(m), threads).passes(), 1u);
    const model::SolverOptions options{
        .integrator = c.bar.implicit ? model::Integrator::implicit_step : model::Integrator::explicit_step,
        .iterations = 10};
    model::State first;
    for (const auto& [simd, threads] :
         {std::pair{Simd::scalar, 2u}, {Simd::automatic, 1u}, {Simd::automatic, 3u}, {Simd::baseline, 2u}}) {
      auto solver = cpu_reference::make_cpu_solver(m, options, threads, simd);
      BarMotion motion(m, c.substeps, c.bar.cuts);
      for (std::uint64_t frame = 1; frame <= 4; ++frame) {
        Nobody nobody;
        solver->submit(motion.drive(frame), {}, frame == 2 ? &nobody : nullptr);
        solver->collect();
        if (frame != 3) continue;
        const model::State state = solver->save();
        solver = cpu_reference::make_cpu_solver(m, options, threads, simd);
        solver->load(state);
      }
      model::State state = solver->save();
      if (first.positions.empty())
        first = std::move(state);
      else
        EXPECT_TRUE(first == state) << name_of(simd) << ", " << threads << " threads, " << c.name;
    }
  }
}

}  // namespace
}  // namespace fascicle::tests
