// Stages in lanes compared with the scalar stages: the same bits at every SIMD level of the machine, for any
// number of threads.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "cpu_reference/solver/cpu_solver.h"
#include "cpu_reference/solver/slices.h"
#include "tests/cpu_reference/solver_runs.h"
#include "tests/support/bar_model.h"
#include "tests/support/test_models.h"

namespace fascicle::tests {
namespace {

using cpu_reference::available_simd;
using cpu_reference::make_cpu_solver;
using cpu_reference::Simd;
using model::Model;

model::SolverOptions options_of(const Model& model) {
  if (!model.is_implicit()) return {};
  return {.integrator = model::Integrator::implicit_step, .iterations = 7};
}

struct Motion {
  std::vector<model::Frame> frames;
  std::vector<model::State> states;
};

Motion run(const Model& model, Simd simd, unsigned threads, int frames, model::SolverOptions options) {
  const auto solver = make_cpu_solver(model, options, threads, simd);
  Sway sway(model);
  Motion motion;
  for (int k = 1; k <= frames; ++k) {
    solver->submit(sway.at(static_cast<std::uint64_t>(k)),
                   {.positions = true, .velocities = true, .surface = true, .skinned = true});
    motion.frames.push_back(solver->collect());
    motion.states.push_back(solver->save());
  }
  return motion;
}

// Every level and number of threads matches the scalar stages, frame by frame.
void expect_same_bits(const Model& model, int frames, const model::SolverOptions& options) {
  const Motion scalar = run(model, Simd::scalar, 1, frames, options);
  for (const Simd simd : available_simd())
    for (const unsigned threads : {1U, 2U, 8U}) {
      SCOPED_TRACE(std::string(name_of(simd)) + ", " + std::to_string(threads) + " threads");
      const Motion other = run(model, simd, threads, frames, options);
      for (std::size_t k = 0; k < scalar.frames.size(); ++k) {
        ASSERT_EQ(scalar.frames[k].positions, other.frames[k].positions) << "frame " << k + 1;
        ASSERT_EQ(scalar.frames[k].velocities, other.frames[k].velocities) << "frame " << k + 1;
        ASSERT_EQ(scalar.frames[k].surface, other.frames[k].surface) << "frame " << k + 1;
        ASSERT_EQ(scalar.frames[k].skinned, other.frames[k].skinned) << "frame " << k + 1;
        ASSERT_EQ(scalar.states[k], other.states[k]) << "frame " << k + 1;
      }
    }
}
void expect_same_bits(const Model& model, int frames = 10) {
  expect_same_bits(model, frames, options_of(model));
}

// If the build lost a level, all other tests would just skip it.
TEST(Lanes, EveryLevelOfTheMachineIsThere) {
  const std::vector<Simd> levels = available_simd();
  const auto has = [&levels](Simd level) {
    return std::find(levels.begin(), levels.end(), level) != levels.end();
  };
  EXPECT_EQ(levels.front(), Simd::scalar);
  EXPECT_TRUE(has(Simd::baseline));
#if defined(__x86_64__) || defined(__i386__)
  EXPECT_EQ(has(Simd::sse4), __builtin_cpu_supports("sse4.1") != 0);
  EXPECT_EQ(has(Simd::avx2), __builtin_cpu_supports("avx2") != 0);
  const bool has_avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                          __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
  EXPECT_EQ(has(Simd::avx512), has_avx512);
#endif
}

// Large enough for chunks of many slices, an incomplete one at the end, and prefetching.
TEST(Lanes, HaveTheScalarBitsOnALargerModel) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Model model = random_model(seed, 12);
    EXPECT_GT(model.vertex_count, 500u);
    expect_same_bits(model, 3);
  }
}

TEST(Lanes, HaveTheScalarBitsOnRandomModels) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    expect_same_bits(random_model(seed));
  }
}

TEST(Lanes, HaveTheScalarBitsWithMuellersRotation) {
  for (unsigned seed = 0; seed < 6; ++seed)
    expect_same_bits(random_model(seed), 5, {.rotation = model::Rotation::mueller2016});
}

TEST(Lanes, HaveTheScalarBitsOfTheImplicitIntegrator) {
  for (unsigned seed = 0; seed < 6; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Model model = make_model(jittered(kuhn_bar(5, 3 + seed, 2, 0.1), 0.005, 1, seed), {.beta = 0.6f});
    for (std::uint32_t i = 0; i < model.vertex_count; i += 7) make_kinematic(model, i);
    if (seed % 2 == 1) add_skeleton(model);
    fill_weights(model);
    if (seed % 3 == 2) add_volume(model, 2.0f);
    expect_same_bits(make_implicit(model, 2e4));
  }
}

// With forces, muscles, a skeleton and partly felt acceleration.
TEST(Lanes, HaveTheScalarBitsOfImplicitRandomModels) {
  std::size_t with_forces = 0, with_carried = 0;
  for (unsigned seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Model model = random_model(seed, 4);
    model.momentum_scaled = true;
    const Model implicit = make_implicit(std::move(model), 2e4);
    with_forces += implicit.force_count > 0;
    with_carried +=
        std::any_of(implicit.carried.begin(), implicit.carried.end(), [](float c) { return c > 0; });
    expect_same_bits(implicit);
  }
  EXPECT_GT(with_forces, 2u);
  EXPECT_GT(with_carried, 2u);
}

TEST(Lanes, HaveTheScalarBitsInContact) {
  for (const bool implicit : {false, true}) {
    expect_same_bits(make_bar({.skeleton = true, .forces = true, .implicit = implicit, .contact = true}), 6);
    expect_same_bits(make_bar({.x = 14, .y = 9, .z = 7, .ties = true, .implicit = implicit, .contact = true}),
                     3);
  }
}

// A fan around an edge: two one-rings of 71, more than lanes take at a time, among one-rings of four.
TEST(Lanes, HaveTheScalarBitsInDeepOneRings) {
  constexpr std::uint32_t around = 70;
  Mesh mesh;
  mesh.points = {{0, 0, 0.5}, {0, 0, -0.5}};
  for (std::uint32_t k = 0; k < around; ++k) {
    const double angle = 2 * std::numbers::pi * k / around;
    mesh.points.emplace_back(std::cos(angle), std::sin(angle), 0.1 * (k % 3));
    mesh.tetrahedra.push_back({1, 0, 2 + k, 2 + (k + 1) % around});
  }
  Model model = make_model(mesh, {.beta = 0.3f});
  make_kinematic(model, 2);
  fill_weights(model);
  ASSERT_GT(model.ring_offset[1], 64u);
  expect_same_bits(model);
}

// Regions that take nothing are skipped; vertices that give nothing are their own goal.
TEST(Lanes, HaveTheScalarBitsWhereWeightsAreZero) {
  Model model = make_model(kuhn_bar(6, 3, 3, 0.1), {.alpha = 0.7f});
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    if (model.rest[3 * i] < 0.35f) model.alpha[i] = 0.0f;
  fill_weights(model);
  std::size_t skipped = 0;
  for (std::uint32_t r = 0; r < model.vertex_count; ++r) skipped += model.region_rest[4 * r + 3] == 0.0f;
  ASSERT_GT(skipped, 0u);
  expect_same_bits(model);
}

// The model with `count` kinematic vertices without neighbours inserted before vertex `at`.
Model spread(Model model, std::uint32_t at, std::uint32_t count) {
  const auto put_in = [&](auto& values, std::size_t width, auto value) {
    values.insert(values.begin() + static_cast<std::ptrdiff_t>(width * at), width * count, value);
  };
  put_in(model.source_vertex, 1, 0U);
  put_in(model.rest, 3, 0.0f);
  put_in(model.mass, 1, 1.0);
  put_in(model.alpha, 1, 0.0f);
  put_in(model.beta, 1, 0.0f);
  put_in(model.fibre, 3, 0.0f);
  put_in(model.tag, 1, shader::tag_kinematic);
  put_in(model.pull, 1, 0.0f);
  put_in(model.region_rest, 4, 0.0f);
  put_in(model.ring_offset, 1, model.ring_offset[at]);
  for (std::uint32_t& i : model.ring) i += i < at ? 0 : count;
  for (std::uint32_t& i : model.surface_vertex) i += i < at ? 0 : count;
  for (std::uint32_t& i : model.tetrahedron) i += i < at ? 0 : count;
  model.vertex_count += count;
  return model;
}

// Neighbours further away in memory than 16 bits can address.
TEST(Lanes, HaveTheScalarBitsWhereNeighboursLieFarApart) {
  const Model near = make_model(jittered(kuhn_bar(3, 2, 2, 0.1), 0.005, 1, 5), {.beta = 0.5f});
  EXPECT_TRUE(cpu_reference::make_slices(near).is_compact());
  const Model far = spread(near, 20, 33000);
  EXPECT_FALSE(cpu_reference::make_slices(far).is_compact());
  expect_same_bits(far, 2);
}

// A share of 1 is 2^16 parts, which do not fit into 16 bits.
TEST(Lanes, HaveTheScalarBitsWhereOneRegionHasAVertexAlone) {
  Model model = make_model(kuhn_bar(2, 2, 2, 0.1));
  const std::uint32_t i = 5, first = model.ring_offset[i];
  for (std::uint32_t e = first; e < model.ring_offset[i + 1]; ++e) {
    model.share_given[e] = e == first ? 1.0f : 0.0f;
    const std::uint32_t r = model.ring[e];
    for (std::uint32_t back = model.ring_offset[r]; back < model.ring_offset[r + 1]; ++back)
      if (model.ring[back] == i) model.share_taken[back] = model.share_given[e];
  }
  EXPECT_FALSE(cpu_reference::make_slices(model).is_compact());
  expect_same_bits(model);
}

// The control: a different motion is detected.
TEST(Lanes, ADifferenceWouldBeSeen) {
  const Model model = random_model(3);
  const Motion a = run(model, Simd::automatic, 1, 2, {});
  Model other = model;
  other.alpha.back() = other.alpha.back() == 0.5f ? 0.25f : 0.5f;
  other.share_given.back() += 0x1p-16f;
  const Motion b = run(other, Simd::automatic, 1, 2, {});
  EXPECT_NE(a.states.back(), b.states.back());
}

TEST(Lanes, InstructionsThatTheMachineLacksAreRefused) {
  const Model model = make_model(kuhn_bar(1, 1, 1, 0.1));
  const std::vector<Simd> here = available_simd();
  for (const Simd simd : {Simd::scalar, Simd::baseline, Simd::sse4, Simd::avx2, Simd::avx512}) {
    if (std::find(here.begin(), here.end(), simd) != here.end())
      EXPECT_NO_THROW(make_cpu_solver(model, {}, 1, simd));
    else
      EXPECT_THROW(make_cpu_solver(model, {}, 1, simd), std::invalid_argument) << name_of(simd);
  }
}

TEST(Lanes, LevelsAreFoundByTheirNames) {
  for (const Simd simd :
       {Simd::automatic, Simd::scalar, Simd::baseline, Simd::sse4, Simd::avx2, Simd::avx512})
    EXPECT_EQ(cpu_reference::simd_named(name_of(simd)), simd);
  EXPECT_EQ(cpu_reference::simd_named("mmx"), std::nullopt);
}

}  // namespace
}  // namespace fascicle::tests
