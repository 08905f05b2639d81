// Contact: flesh that overlaps other flesh. The solver is compared with the Oracle. A free body exerts no net
// force or torque on itself, and does the same wherever it is and however it is numbered. Blocks that meet do
// not pass through each other.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "cpu_reference/oracle/oracle.h"
#include "cpu_reference/solver/cpu_solver.h"
#include "host/model/model.h"
#include "host/model/solver.h"
#include "tests/cpu_reference/contact_motion.h"
#include "tests/cpu_reference/oracle_run.h"
#include "tests/cpu_reference/solver_runs.h"
#include "tests/cpu_reference/two_blocks.h"
#include "tests/support/bar_model.h"
#include "tests/support/contact_models.h"
#include "tests/support/test_models.h"

namespace fascicle::tests::contact_test {

namespace {

using cpu_reference::make_cpu_solver;
using cpu_reference::Simd;
using Eigen::Vector3d;
using model::Model;
using model::State;

TEST(Contact, TheModelsKeepTheirPromises) {
  EXPECT_NO_THROW(check_model(make_two_blocks(3, 3, 2, 0.125, 1).model));
  EXPECT_NO_THROW(check_model(make_two_blocks(3, 3, 2, 0.125, 1, true, true).model));
  for (const bool implicit : {false, true})
    EXPECT_NO_THROW(
        check_model(make_bar({.ties = true, .implicit = implicit, .contact = true, .odd_vertices = true})));
}

// The bars that other rooms' tests use are in contact from the first substep on and stay in one piece.
TEST(Contact, BarsAreInContact) {
  for (const bool implicit : {false, true}) {
    const Model m = make_bar({.implicit = implicit, .contact = true});
    const auto solver = make_cpu_solver(m, contact_options(m), 1);
    const auto count = [&](const State& state) {
      std::size_t pressed = 0;
      for (const Vector3d& a : points_in(contact_gains(*solver, m, state, 1.0 / 240.0)))
        pressed += a.norm() > 0.0 ? 1 : 0;
      return pressed;
    };
    EXPECT_GT(count(solver->save()), m.vertex_count / 4);
    BarMotion motion(m, 4);
    for (std::uint64_t k = 1; k <= 12; ++k) solver->submit(motion.drive(k), {});
    const State late = solver->save();
    EXPECT_GT(count(late), m.vertex_count / 4);
    for (const float x : late.positions) EXPECT_LT(std::abs(x), 2.0f);
  }
}

// Barycentric weights are rounded by 2^-24 x coordinate / edge = 6e-7 of the largest, and gradients by as
// much over the height of jittered tetrahedra; 1e-4 is ten times that.
constexpr double rounding = 1e-4;

TEST(Contact, FollowsTheOracle) {
  std::size_t pressed = 0;
  for (unsigned seed = 0; seed < 8; ++seed)
    for (const bool implicit : {false, true}) {
      SCOPED_TRACE("seed " + std::to_string(seed) + (implicit ? ", implicit" : ", explicit"));
      TwoBlocks blocks = make_two_blocks(3, 2 + seed % 2, 3, 0.125, seed, implicit, seed % 3 == 1);
      if (seed >= 6) ignore_some_contact(blocks.model, seed);
      const auto solver = make_cpu_solver(blocks.model, contact_options(blocks.model), 2);
      cpu_reference::Oracle oracle(blocks.model, contact_options(blocks.model));
      const State state = overlapping(blocks, solver->save(), seed);
      const Points ours = points_in(contact_gains(*solver, blocks.model, state, 1.0 / 480.0)),
                   theirs = points_in(contact_gains(oracle, blocks.model, state, 1.0 / 480.0));
      EXPECT_LT(largest_distance(ours, theirs), rounding * largest_in(theirs));
      for (const Vector3d& a : theirs) pressed += a.norm() > 0.0 ? 1 : 0;
      // The moves of the iterations are in the positions. They differ by rounding, but by 0.01 and more
      // without contact.
      const auto places_of = [&](model::Solver& of) {
        return points_in(contact_response(of, blocks.model, state, 1.0 / 480.0).after.positions);
      };
      EXPECT_LT(largest_distance(places_of(*solver), places_of(oracle)), 2e-5);
    }
  EXPECT_GT(pressed, 200u);
}

// Both impulses of a contact act at one place, where the substep began. An explicit pass keeps x - h v, so it
// changes the angular momentum by the impulses' moment there. Settling in the implicit integrator acts about
// the positions at the substep's start; at its end the two sides have slid apart. Weights are rounded by
// 2^-24 of a coordinate over an edge and gains by 2^-24 of the velocities, with one error per contact. The
// control: a corner that is not pushed back.
TEST(Contact, PushesAndTurnsABodyByNothing) {
  for (const bool implicit : {false, true}) {
    SCOPED_TRACE(implicit ? "implicit" : "explicit");
    const TwoBlocks blocks = make_two_blocks(3, 3, 3, 0.125, 5, implicit);
    const Model& m = blocks.model;
    const double h = 1.0 / 480.0;
    const auto solver = make_cpu_solver(m, contact_options(m), 1);
    // The first substep of the implicit integrator uses a one-step method, as after a cut.
    solver->load(overlapping(blocks, solver->save(), 2));
    TestDrive quiet = quiet_drive(m, h);
    solver->submit(quiet.get(), {});
    const State began = solver->save();
    const ContactResponse response = contact_response(*solver, m, began, h);
    const Points v = points_in(response.before.velocities),
                 x = points_in(implicit ? began.positions : response.before.positions),
                 moved = implicit ? x : points_in(response.after.positions);
    Points changed = points_in(response.after.velocities);
    double size = 0.0;
    for (std::uint32_t i = 0; i < m.vertex_count; ++i) size += m.mass[i] * (changed[i] - v[i]).norm();
    ASSERT_GT(size, 0.0);
    const auto gained = [&] {
      const Momentum before = momentum_of(m, x, v), after = momentum_of(m, moved, changed);
      return Momentum{after.linear - before.linear, after.angular - before.angular};
    };
    EXPECT_LT(gained().linear.norm(), 2e-6 * size);
    EXPECT_LT(gained().angular.norm(), 2e-6 * size);
    std::size_t most = 0;
    for (std::size_t i = 0; i < v.size(); ++i)
      if ((changed[i] - v[i]).norm() > (changed[most] - v[most]).norm()) most = i;
    changed[most] = v[most];
    EXPECT_GT(gained().linear.norm(), 1e-3 * size);
    EXPECT_GT(gained().angular.norm(), 1e-3 * size);
  }
}

// The two sides of a contact yield in proportion to 1/(1 - a) times their masses; when the iterations
// converge, the forces sum to zero. After 20 iterations a free body gains 2e-6 of the momentum that its
// contacts exchange in a substep, as much as rounding gives it without contact. The control: a side that is
// not pushed back.
TEST(Contact, IterationsKeepTheMomentumOfAFreeBodyNearly) {
  const TwoBlocks blocks = make_two_blocks(3, 3, 3, 0.125, 5, true);
  const Model alone = without_contact(blocks.model);
  const auto with = make_cpu_solver(blocks.model, contact_options(blocks.model), 1),
             without = make_cpu_solver(alone, contact_options(alone), 1);
  State state = overlapping(blocks, with->save(), 2);
  TestDrive quiet = quiet_drive(blocks.model, 1.0 / 480.0);
  for (int k = 0; k < 4; ++k) {
    for (model::Solver* solver : {with.get(), without.get()}) {
      solver->load(state);
      solver->submit(quiet.get(), {});
      solver->collect();
    }
    const Points v = points_in(state.velocities), held = points_in(with->save().velocities),
                 free = points_in(without->save().velocities), x = points_in(state.positions);
    double exchanged = 0.0;
    for (std::uint32_t i = 0; i < blocks.model.vertex_count; ++i)
      exchanged += blocks.model.mass[i] * (held[i] - free[i]).norm();
    const Vector3d gained =
        momentum_of(blocks.model, x, held).linear - momentum_of(blocks.model, x, v).linear;
    const Vector3d of_free =
        momentum_of(blocks.model, x, free).linear - momentum_of(blocks.model, x, v).linear;
    ASSERT_GT(exchanged, 0.0);
    EXPECT_LT(gained.norm(), 1e-5 * exchanged);
    EXPECT_LT(of_free.norm(), 1e-5 * exchanged);
    Points bent = held;
    for (std::uint32_t i = blocks.first_of_second; i < blocks.model.vertex_count; ++i) bent[i] = free[i];
    EXPECT_GT((momentum_of(blocks.model, x, bent).linear - momentum_of(blocks.model, x, v).linear).norm(),
              0.01 * exchanged);
    state = with->save();
  }
}

// A quarter turn and a translation.
TEST(Contact, DoesTheSameWhereverTheBodyStands) {
  for (const bool implicit : {false, true}) {
    const TwoBlocks blocks = make_two_blocks(3, 3, 2, 0.125, 6, implicit);
    const auto solver = make_cpu_solver(blocks.model, contact_options(blocks.model), 1);
    const State here = overlapping(blocks, solver->save(), 8);
    State there = here;
    for (std::size_t i = 0; i < blocks.model.vertex_count; ++i) {
      for (std::vector<float>* values : {&there.positions, &there.velocities})
        std::tie((*values)[3 * i], (*values)[3 * i + 1]) = std::pair{-(*values)[3 * i + 1], (*values)[3 * i]};
      there.positions[3 * i] += 0.5f;
    }
    Points a = points_in(contact_gains(*solver, blocks.model, here, 1.0 / 480.0));
    const Points b = points_in(contact_gains(*solver, blocks.model, there, 1.0 / 480.0));
    ASSERT_GT(largest_in(a), 0.0);
    for (Vector3d& x : a) x = Vector3d(-x.y(), x.x(), x.z());
    EXPECT_LT(largest_distance(a, b), rounding * largest_in(a));
  }
}

// A vertex's contacts are summed in another order.
TEST(Contact, NumberingMattersByRoundingOnly) {
  const Mesh mesh = two_blocks_mesh(3, 3, 3, 0.125, 7);
  const auto n = std::uint32_t(mesh.points.size());
  std::vector<std::uint32_t> new_number(n);
  std::iota(new_number.begin(), new_number.end(), 0u);
  std::mt19937 random(11);
  std::shuffle(new_number.begin(), new_number.end(), random);
  Mesh other = mesh;
  for (std::uint32_t i = 0; i < n; ++i) other.points[new_number[i]] = mesh.points[i];
  for (auto& t : other.tetrahedra)
    for (std::uint32_t& i : t) i = new_number[i];
  const auto model_of = [](const Mesh& of) {
    TwoBlocks blocks{make_model(of), std::uint32_t(of.points.size() / 2), 0.125};
    add_contact(blocks.model, 0.1875, depth_below_boundary(blocks.model));
    return blocks;
  };
  const TwoBlocks a = model_of(mesh), b = model_of(other);
  const auto of_a = make_cpu_solver(a.model, {}, 1), of_b = make_cpu_solver(b.model, {}, 1);
  const State state = overlapping(a, of_a->save(), 4);
  State renumbered = of_b->save();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t c = 0; c < 3; ++c) {
      renumbered.positions[3 * new_number[i] + c] = state.positions[3 * i + c];
      renumbered.velocities[3 * new_number[i] + c] = state.velocities[3 * i + c];
    }
  const Points ours = points_in(contact_gains(*of_a, a.model, state, 1.0 / 480.0)),
               theirs = points_in(contact_gains(*of_b, b.model, renumbered, 1.0 / 480.0));
  Points back(n);
  for (std::uint32_t i = 0; i < n; ++i) back[i] = theirs[new_number[i]];
  ASSERT_GT(largest_in(ours), 0.0);
  EXPECT_LT(largest_distance(ours, back), rounding * largest_in(ours));
  EXPECT_GT(largest_distance(ours, theirs), 0.1 * largest_in(ours)) << "nothing was renumbered";
}

// The distance of the second block's centre beyond the first one's.
double apart(const TwoBlocks& blocks, const State& state) {
  double sum = 0.0;
  for (std::uint32_t i = 0; i < blocks.model.vertex_count; ++i)
    sum += (i < blocks.first_of_second ? -1.0 : 1.0) * double(state.positions[3 * std::size_t{i}]);
  return sum / double(blocks.first_of_second);
}

double kinetic_energy(const Model& m, const State& state) {
  double sum = 0.0;
  for (std::uint32_t i = 0; i < m.vertex_count; ++i)
    sum += 0.5 * m.mass[i] * triple_at(state.velocities, i).squaredNorm();
  return sum;
}

// The control: without contact they pass through each other.
TEST(Contact, BlocksThatMeetDoNotPassThroughEachOther) {
  for (const bool implicit : {false, true}) {
    SCOPED_TRACE(implicit ? "implicit" : "explicit");
    const TwoBlocks blocks = make_two_blocks(3, 3, 3, 0.125, 3, implicit);
    const double h = 1.0 / 480.0;
    const auto end_of = [&](const Model& m, double& most_energy) {
      const auto solver = make_cpu_solver(m, contact_options(m), 2);
      solver->load(thrown(blocks, solver->save(), 0.5));
      const double start = kinetic_energy(m, solver->save());
      TestDrive quiet = quiet_drive(m, h, 8);
      most_energy = 0.0;
      double least_apart = 10.0;
      for (int k = 0; k < 120; ++k) {
        solver->submit(quiet.get(), {});
        const State state = solver->save();
        most_energy = std::max(most_energy, kinetic_energy(m, state) / start);
        least_apart = std::min(least_apart, apart(blocks, state));
      }
      return least_apart;
    };
    double energy = 0.0;
    EXPECT_GT(end_of(blocks.model, energy), 0.25) << "0.38 is the distance at which they touch";
    // The push beyond a margin is the gradient of an energy only in undeformed flesh; a hundredth allows for
    // the deformation.
    EXPECT_LT(energy, 1.01);
    EXPECT_LT(end_of(without_contact(blocks.model), energy), 0.0);
  }
}

TEST(Contact, LanesAndThreadsHaveTheScalarBits) {
  std::vector<Model> models;
  for (const bool implicit : {false, true}) {
    models.push_back(make_two_blocks(3, 3, 3, 0.125, 3, implicit).model);
    models.push_back(
        make_bar({.skeleton = true, .muscle = true, .ties = true, .implicit = implicit, .contact = true}));
  }
  for (const Model& m : models) {
    const TwoBlocks as_blocks{m, m.vertex_count / 2, 0.125};
    const auto run = [&](Simd simd, unsigned threads) {
      const auto solver = make_cpu_solver(m, contact_options(m), threads, simd);
      if (!m.has_skeleton()) solver->load(overlapping(as_blocks, solver->save(), 2));
      Sway sway(m);
      for (std::uint64_t k = 1; k <= 10; ++k) solver->submit(sway.at(k), {});
      return solver->save();
    };
    const State scalar = run(Simd::scalar, 1);
    for (const Simd simd : cpu_reference::available_simd())
      for (const unsigned threads : {1u, 3u}) EXPECT_EQ(run(simd, threads), scalar) << name_of(simd);
  }
}

// What the search remembers of earlier substeps is not part of a State.
TEST(Contact, GoesOnFromASavedState) {
  for (const bool implicit : {false, true}) {
    const TwoBlocks blocks = make_two_blocks(3, 3, 3, 0.125, 3, implicit);
    const model::SolverOptions options = contact_options(blocks.model);
    TestDrive quiet = quiet_drive(blocks.model, 1.0 / 480.0, 4);
    const auto whole = make_cpu_solver(blocks.model, options, 2),
               late = make_cpu_solver(blocks.model, options, 1),
               other = make_cpu_solver(blocks.model, options, 3);
    whole->load(thrown(blocks, whole->save(), 0.5));
    other->load(overlapping(blocks, other->save(), 7));
    for (int k = 0; k < 10; ++k)
      for (model::Solver* solver : {whole.get(), other.get()}) solver->submit(quiet.get(), {});
    const State middle = whole->save();
    // One solver without memory, and one that remembers another motion.
    late->load(middle);
    other->load(middle);
    for (int k = 0; k < 10; ++k)
      for (model::Solver* solver : {whole.get(), late.get(), other.get()}) solver->submit(quiet.get(), {});
    EXPECT_NE(whole->save(), middle);
    EXPECT_EQ(late->save(), whole->save());
    EXPECT_EQ(other->save(), whole->save());
  }
}

// Contact arrays alone change no bit: until flesh meets, the body moves as without them.
TEST(Contact, WithoutAMeetingNothingChanges) {
  for (unsigned seed = 0; seed < 6; ++seed) {
    Model plain = random_model(seed);
    plain.momentum_scaled = true;
    fill_weights(plain);
    if (seed % 2 == 1) plain = make_implicit(plain, 2e4);
    Model touching = plain;
    add_contact(touching, 100.0, depth_below_boundary(plain));
    const auto a = make_cpu_solver(plain, contact_options(plain), 1),
               b = make_cpu_solver(touching, contact_options(touching), 2);
    Sway sway(plain);
    for (std::uint64_t k = 1; k <= 10; ++k) {
      a->submit(sway.at(k), {});
      b->submit(sway.at(k), {});
    }
    EXPECT_EQ(a->save(), b->save()) << seed;
  }
}

}  // namespace

}  // namespace fascicle::tests::contact_test
