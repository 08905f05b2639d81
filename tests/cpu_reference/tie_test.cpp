// Ties: sliding skin. The solvers match the Oracle's formulas. A free body exerts no net force or torque on
// itself, stays at rest, and does the same wherever it is. Skin is free along the flesh and held across it.
#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "cpu_reference/oracle/oracle.h"
#include "cpu_reference/solver/cpu_solver.h"
#include "host/model/validate.h"
#include "tests/cpu_reference/solver_runs.h"
#include "tests/support/sliding_models.h"

namespace fascicle::tests::tie_test {

namespace {

using cpu_reference::make_cpu_solver;
using cpu_reference::Simd;
using Eigen::Vector3d;
using model::Model;
using model::State;

Vector3d triple(const std::vector<float>& values, std::uint32_t i) {
  return Vector3d(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
}

struct Momentum {
  Vector3d linear = Vector3d::Zero(), angular = Vector3d::Zero();
  double size = 0.0;  // sum of m |v|
};

Momentum momentum_of(const Model& model, const State& state) {
  Momentum sum;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    const Vector3d p = model.mass[i] * triple(state.velocities, i);
    sum.linear += p;
    sum.angular += triple(state.positions, i).cross(p);
    sum.size += p.norm();
  }
  return sum;
}

model::SolverOptions options_for(const Model& model) {
  if (!model.is_implicit()) return {};
  return {.integrator = model::Integrator::implicit_step, .iterations = 20};
}

// Displaces every vertex slightly, with a random velocity, and moves the skin off its flesh by a tenth of a
// tie.
State shaken(const Model& model, State state, double size) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  displace_skin(model, Vector3d(0.01, 0.0125, -0.01), state.positions);
  for (std::size_t k = 0; k < state.positions.size(); ++k) {
    state.positions[k] += float(size * normal(random));
    state.velocities[k] += float(10.0 * size * normal(random));
  }
  return state;
}

TEST(Tie, TheModelKeepsItsPromises) {
  EXPECT_NO_THROW(check_model(bar_with_skin()));
  EXPECT_NO_THROW(check_model(bar_with_skin(true)));
}

// By hand, on a regular tetrahedron: all masses are m, the foot is at the centre, b_j = 1/3, and the corners
// have no other tie, so k = 0.5 / (1/m + 3 (1/9)/m) = 3/8 m. The skin moves by 3/8 of the error, and each
// corner by a third of that in the opposite direction.
TEST(Tie, DrawsBothEndsByHalfOfWhatIsWrongInAll) {
  Model m = make_model(regular_tetrahedron(), {.alpha = 0.0f});
  add_sliding(m, [](const Vector3d& p) { return p.x() > 0.0 && p.y() > 0.0; });
  ASSERT_EQ(m.tie.size(), 1u);
  const State rest = make_cpu_solver(m, {}, 1)->save();
  State state = rest;
  displace_skin(m, Vector3d(0.3, 0.3, 0.3), state.positions);
  const auto solver = make_cpu_solver(m, {}, 1);
  solver->load(state);
  TestDrive quiet = quiet_drive(m, 0.5);
  solver->submit(quiet.get(), {});
  const State after = solver->save();
  const Vector3d wrong(0.3, 0.3, 0.3);
  EXPECT_LT((triple(after.positions, 0) - (triple(state.positions, 0) - 3.0 / 8.0 * wrong)).norm(), 1e-6);
  for (std::uint32_t i = 1; i < 4; ++i)
    EXPECT_LT((triple(after.positions, i) - (triple(state.positions, i) + wrong / 8.0)).norm(), 1e-6);
}

// The relative change of a free body's momenta over 400 substeps.
double change_of_momentum(const Model& model, model::Solver& solver) {
  const State start = shaken(model, solver.save(), 1e-3);
  solver.load(start);
  TestDrive quiet = quiet_drive(model, 1.0 / 480.0, 40);
  for (int k = 0; k < 10; ++k) solver.submit(quiet.get(), {});
  const Momentum before = momentum_of(model, start), after = momentum_of(model, solver.save());
  return std::max((after.linear - before.linear).norm(), (after.angular - before.angular).norm()) /
         before.size;
}

// The same body with ties but without stiffness.
Model slack(Model model) {
  std::fill(model.alpha.begin(), model.alpha.end(), 0.0f);
  fill_weights(model);
  return model;
}

Model without_ties(Model model) {
  model.tie.clear();
  model.tie_offset.clear();
  model.tie_index.clear();
  model.tie_coefficient.clear();
  return model;
}

// The Oracle is exact up to rounding its state, 6e-8, and the weights to floats. In float, ties alone are
// exact to 6e-8 of each substep's change, which is as large as the momenta themselves; regions add the same
// error as without ties. The control: a tie with half of its counterforce.
TEST(Tie, AFreeBodyKeepsItsMomentum) {
  Model m = bar_with_skin();
  cpu_reference::Oracle oracle(m, {});
  EXPECT_LT(change_of_momentum(m, oracle), 1e-6);
  EXPECT_LT(change_of_momentum(slack(m), *make_cpu_solver(slack(m), {}, 1)), 2e-5);
  EXPECT_LT(change_of_momentum(m, *make_cpu_solver(m, {}, 1)),
            2.0 * change_of_momentum(without_ties(m), *make_cpu_solver(without_ties(m), {}, 1)));
  const Model implicit = make_implicit(m, 2e4);
  // Up to the tolerance of the iterations.
  EXPECT_LT(change_of_momentum(implicit, *make_cpu_solver(implicit, options_for(implicit), 1)), 1e-2);
  for (std::uint32_t i = 0; i < m.vertex_count; ++i)
    for (std::uint32_t e = m.tie_offset[i]; e < m.tie_offset[i + 1]; ++e)
      if (m.tie[m.tie_index[e]].sliding != i) m.tie_coefficient[e] *= 0.5f;
  EXPECT_GT(change_of_momentum(slack(m), *make_cpu_solver(slack(m), {}, 1)), 1e-2);
}

// Ties alone drift only by rounding; with regions, the body drifts no more than one without ties.
TEST(Tie, ABodyAtRestStaysThere) {
  const Model m = bar_with_skin();
  EXPECT_LT(drift_at_rest(m, *make_cpu_solver(slack(m), {}, 1)), 1e-5);
  EXPECT_LT(drift_at_rest(m, *make_cpu_solver(m, {}, 1)),
            drift_at_rest(m, *make_cpu_solver(without_ties(m), {}, 1)));
  const Model implicit = make_implicit(m, 2e4);
  EXPECT_LT(drift_at_rest(implicit, *make_cpu_solver(implicit, options_for(implicit), 1)), 1e-4);
}

// A quarter turn and a translation by a power of two change no differences of positions; only the order of
// sums differs.
TEST(Tie, DoesTheSameWhereverTheBodyStands) {
  for (const Model& m : {bar_with_skin(), make_implicit(bar_with_skin(), 2e4)}) {
    const auto here = make_cpu_solver(m, options_for(m), 1), there = make_cpu_solver(m, options_for(m), 1);
    const State start = shaken(m, here->save(), 1e-3);
    State turned = start;
    const double half = std::sqrt(0.5);
    for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
      for (std::vector<float>* values : {&turned.positions, &turned.velocities})
        std::tie((*values)[3 * i], (*values)[3 * i + 1]) = std::pair{-(*values)[3 * i + 1], (*values)[3 * i]};
      turned.positions[3 * i] += 0.5f;
      for (std::size_t k = 0; k < 4; ++k) turned.rotations[4 * i + k] = float(k == 0 || k == 3 ? half : 0.0);
    }
    here->load(start);
    there->load(turned);
    TestDrive quiet = quiet_drive(m, 1.0 / 480.0, 20);
    here->submit(quiet.get(), {});
    there->submit(quiet.get(), {});
    const State a = here->save(), b = there->save();
    for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
      const Vector3d p = triple(a.positions, i);
      EXPECT_LT((triple(b.positions, i) - Vector3d(0.5 - p.y(), p.x(), p.z())).norm(), 2e-5) << i;
    }
  }
}

// Metres, for a bar of 0.75 that falls by 0.02 to 1. Rounding, amplified by the regions' rotations: 4e-5 with
// and without ties. mueller2016 rotates once a substep and lags in explicit ones, by 3e-4 with and without
// ties.
TEST(Tie, FollowsTheOracle) {
  for (const bool implicit : {false, true})
    for (const auto rotation : {model::Rotation::qcp, model::Rotation::mueller2016}) {
      const bool lags = !implicit && rotation == model::Rotation::mueller2016;
      const Model m = implicit ? make_implicit(bar_with_skin(true), 2e4) : bar_with_skin(true);
      model::SolverOptions options = options_for(m);
      options.rotation = rotation;
      const auto solver = make_cpu_solver(m, options, 2);
      cpu_reference::Oracle oracle(m, options);
      TestDrive fall = quiet_drive(m, lags ? 1.0 / 960.0 : 1.0 / 240.0, 4, {0.5, -9.81, 2.0});
      const model::Distance distance = distance_to(
          m, *solver, oracle, [&](std::uint64_t) { return fall.get(); }, 30);
      EXPECT_LT(distance.largest, lags ? 1e-3 : 1e-4)
          << (implicit ? "implicit " : "explicit ") << name_of(rotation);
    }
}

TEST(Tie, LanesAndThreadsHaveTheScalarBits) {
  for (const Model& m : {bar_with_skin(true), make_implicit(bar_with_skin(true), 2e4)}) {
    const auto run = [&](Simd simd, unsigned threads) {
      const auto solver = make_cpu_solver(m, options_for(m), threads, simd);
      solver->load(shaken(m, solver->save(), 1e-3));
      TestDrive fall = quiet_drive(m, 1.0 / 240.0, 4, {0.5, -9.81, 2.0});
      for (int k = 0; k < 10; ++k) solver->submit(fall.get(), {});
      return solver->save();
    };
    const State scalar = run(Simd::scalar, 1);
    for (const Simd simd : cpu_reference::available_simd())
      for (const unsigned threads : {1u, 3u}) EXPECT_EQ(run(simd, threads), scalar) << name_of(simd);
  }
}

// How strongly displaced skin is pulled back: its change of momentum in a substep, relative to its mass and
// displacement, in units of 1/h.
double resistance(const Model& model, const Vector3d& offset) {
  const auto solver = make_cpu_solver(model, options_for(model), 1);
  State state = solver->save();
  displace_skin(model, offset, state.positions);
  solver->load(state);
  const double h = 1.0 / 480.0;
  TestDrive quiet = quiet_drive(model, h);
  solver->submit(quiet.get(), {});
  const State after = solver->save();
  Vector3d momentum = Vector3d::Zero();
  double mass = 0.0;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    if (model.layer_of(i) + 1 != model.layers.size()) continue;
    momentum += model.mass[i] * triple(after.velocities, i);
    mass += model.mass[i];
  }
  return -momentum.dot(offset) / (mass * offset.squaredNorm()) * h;
}

// The skin is flat, so along and across are well defined. Ties do nothing along it. Without sliding, regions
// shared by skin and flesh pull it back.
TEST(Tie, SkinIsFreeAlongTheFleshAndHeldAcrossIt) {
  const auto is_skin = [](const Vector3d& p) { return p.y() > 0.33; };
  const Mesh mesh = kuhn_bar(6, 3, 4, 0.125);
  Model sliding = make_model(mesh), fast = sliding;
  add_sliding(sliding, is_skin);
  fast.layers.push_back(fast.layers[0]);
  for (std::uint32_t i = 0; i < fast.vertex_count; ++i)
    if (is_skin(triple(fast.rest, i))) fast.tag[i] |= 1;
  const double along = 0.1 * 0.125;
  for (const Vector3d& shove : {Vector3d(along, 0, 0), Vector3d(0, 0, along)}) {
    EXPECT_LT(5.0 * resistance(sliding, shove), resistance(fast, shove));
    EXPECT_GE(resistance(sliding, shove), -1e-6);
  }
  for (const double push : {-along, along}) {
    const double held = resistance(sliding, Vector3d(0, push, 0));
    EXPECT_GT(held, 0.5 * resistance(fast, Vector3d(0, push, 0)));
    // Of two vertices of equal mass, each would move by a quarter; corners have several ties and more mass.
    EXPECT_GT(held, 0.2);
    EXPECT_LT(held, 0.5);
  }
}

// Springs evaluated at the beginning of a substep would amplify their own oscillation under BDF2
// (sliding-skin.md). A shaken body comes to rest with no damping but the integrator's.
TEST(Tie, TheImplicitIntegratorFeedsNoOscillation) {
  const Model m = make_implicit(bar_with_skin(), 2e3);
  const auto solver = make_cpu_solver(m, options_for(m), 2);
  solver->load(shaken(m, solver->save(), 1e-3));
  const auto energy = [&] {
    const State state = solver->save();
    double sum = 0.0;
    for (std::uint32_t i = 0; i < m.vertex_count; ++i)
      sum += 0.5 * m.mass[i] * triple(state.velocities, i).squaredNorm();
    return sum;
  };
  TestDrive quiet = quiet_drive(m, 1.0 / 120.0, 20);
  solver->submit(quiet.get(), {});
  const double early = energy();
  for (int k = 0; k < 20; ++k) solver->submit(quiet.get(), {});
  EXPECT_LT(energy(), early);
}

}  // namespace

}  // namespace fascicle::tests::tie_test
