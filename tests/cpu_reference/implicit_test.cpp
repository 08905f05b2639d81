// The implicit integrator on small bodies: CpuSolver compared with the Oracle, and properties of every step.
#include "host/model/implicit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <numbers>
#include <vector>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <gtest/gtest.h>

#include "cpu_reference/oracle/oracle.h"
#include "cpu_reference/oracle/oracle_implicit.h"
#include "cpu_reference/solver/cpu_solver.h"
#include "host/model/validate.h"
#include "tests/cpu_reference/oracle_run.h"
#include "tests/cpu_reference/solver_runs.h"
#include "tests/support/test_models.h"

namespace fascicle::tests::implicit_test {

namespace {

using cpu_reference::make_cpu_solver;
using cpu_reference::Oracle;
using Eigen::Vector3d;
using model::Frame;
using model::Model;
using model::Solver;

constexpr model::SolverOptions implicit{.integrator = model::Integrator::implicit_step};
constexpr model::Read both{.positions = true, .velocities = true};

Vector3d triple(const std::vector<float>& values, std::size_t i) {
  return Vector3d(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
}

// A small bar held at its low x end; E in Pa.
Model held_bar(double E, float beta = 0.0f, double damping = 0.0) {
  BodyOptions options;
  options.beta = beta;
  options.fibre = {0.6, 0.8, 0.0};
  options.damping = damping;
  options.kinematic = [](const Vector3d& p) { return p.x() < 1e-3; };
  return make_implicit(make_model(jittered(kuhn_bar(6, 2, 2, 1.0 / 32), 1.0 / 4096, 8, 3), options), E);
}

Model free_bar(double E, float beta, double density = 1000.0) {
  BodyOptions options;
  options.beta = beta;
  options.fibre = {0.6, 0.8, 0.0};
  options.density = density;
  return make_implicit(make_model(jittered(kuhn_bar(6, 2, 2, 1.0 / 32), 1.0 / 4096, 8, 3), options), E);
}

// Skeletons, muscles, forces and shares of the skeleton's acceleration, as in explicit random models.
// Rounding is amplified by at most 1 / (1 - a), a few hundred here, and by over-relaxation: 20 frames stay
// below 1e-4 of the bodies' quarter of a metre.
TEST(Implicit, CpuStaysNearTheOracle) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    Model model = random_model(seed);
    model.momentum_scaled = true;
    // The volume term depends on the weights, which change here; its gain is at most what a scene can have.
    const bool has_volume = !model.volume_gain.empty();
    model.volume_gain.clear();
    model.region_volume.clear();
    model = make_implicit(model, 2e3 * (seed + 1));
    if (has_volume) add_volume(model, 1.5f);
    check_model(model);
    constexpr double h = 1.0 / 180.0;
    // None, a part of the substep, and more than counts.
    model::SolverOptions options = implicit;
    options.viscosity = std::array{0.0, 0.7 * h, 3.0 * h}[seed % 3];
    const auto solver = make_cpu_solver(model, options, 2);
    Oracle oracle(model, options);
    oracle.load(solver->save());
    Sway sway(model, h);
    const model::Distance distance = model::distance_to(
        model, *solver, oracle, [&](std::uint64_t k) { return sway.at(k); }, 20);
    EXPECT_LT(distance.largest, 2.5e-5)
        << "seed " << seed << " frame " << distance.frame << " vertex " << distance.vertex;
    EXPECT_GT(distance.largest, 0.0);
  }
}

// Threads, probes, and saving and loading a state during a motion change no bit; a probe sees each iteration.
TEST(Implicit, ThreadsProbesAndSavingDoNotMatter) {
  for (unsigned seed = 0; seed < 6; ++seed) {
    Model model = random_model(seed);
    model.momentum_scaled = true;
    model = make_implicit(model, 5e3);
    struct Watch : model::Probe {
      void on_stage(const model::Where& where, std::span<const float>) override {
        relaxed += where.stage == model::Stage::relax && where.iteration + 1 == implicit.iterations;
      }
      int relaxed = 0;
    } watch;
    const auto one = make_cpu_solver(model, implicit, 1), three = make_cpu_solver(model, implicit, 3);
    std::unique_ptr<Solver> resumed = make_cpu_solver(model, implicit, 1);
    Sway sway(model, 1.0 / 180.0);
    for (std::uint64_t k = 1; k <= 4; ++k) {
      one->submit(sway.at(k), both);
      three->submit(sway.at(k), both, &watch);
      const model::State state = resumed->save();
      resumed = make_cpu_solver(model, implicit, 2);
      resumed->load(state);
      resumed->submit(sway.at(k), both);
      const Frame a = one->collect(), b = three->collect(), c = resumed->collect();
      ASSERT_EQ(a.positions, b.positions) << seed;
      ASSERT_EQ(a.velocities, b.velocities) << seed;
      ASSERT_EQ(a.positions, c.positions) << seed;
      ASSERT_EQ(a.velocities, c.velocities) << seed;
    }
    EXPECT_EQ(watch.relaxed, 12);
    EXPECT_EQ(one->save(), three->save());
  }
}

// A substep of another length cannot serve as history, in either solver.
TEST(Implicit, ChangingTheStepBeginsAnew) {
  const Model model = held_bar(2e4);
  const auto solver = make_cpu_solver(model, implicit, 1);
  Oracle oracle(model, implicit);
  double largest = 0.0;
  for (const double h : {1.0 / 60, 1.0 / 60, 1.0 / 240, 1.0 / 240, 1.0 / 30}) {
    TestDrive drive = quiet_drive(model, h, 1, {0, -9.81, 0});
    solver->submit(drive.get(), both);
    oracle.submit(drive.get(), both);
    const Frame a = solver->collect(), b = oracle.collect();
    for (std::size_t i = 0; i < model.vertex_count; ++i)
      largest = std::max(largest, (triple(a.positions, i) - triple(b.positions, i)).norm());
  }
  EXPECT_LT(largest, 2e-6);  // a few roundings of 6e-8 a step, on a body 0.2 long
}

// A free body that nothing deforms falls with v + h f, whatever its stiffness.
TEST(Implicit, AFreeBodyFallsAsItShould) {
  const Model model = free_bar(2e3, 0.0f);
  const auto solver = make_cpu_solver(model, implicit, 1);
  TestDrive drive = quiet_drive(model, 1.0 / 240, 4, {0, -9.81, 0});
  Frame frame;
  for (int k = 0; k < 30; ++k) {
    solver->submit(drive.get(), both);
    frame = solver->collect();
  }
  // Half a second: g t and g t^2 / 2. 20 iterations leave at most a twentieth of a step, most of which the
  // next starting point contains. The first step is backward Euler and goes g h^2 too far.
  for (std::size_t i = 0; i < model.vertex_count; ++i) {
    EXPECT_NEAR(frame.velocities[3 * i + 1], -9.81 * 0.5, 0.01 * 9.81 * 0.5);
    EXPECT_NEAR(frame.positions[3 * i + 1] - model.rest[3 * i + 1], -9.81 * 0.125, 0.02 * 9.81 * 0.125);
  }
}

// A free body that is stretched unevenly and released exerts no net force on itself. The goals conserve
// momentum but unfinished iterations do not: the error is 1e-6 of the motion if they converge. The test
// allows two thousandths with 20 iterations and a ten-thousandth with 80.
TEST(Implicit, AFreeBodyKeepsItsMomentum) {
  for (const float beta : {0.0f, 1.0f}) {
    const Model model = free_bar(5e3, beta);
    for (const std::uint32_t iterations : {20u, 80u}) {
      const auto solver = make_cpu_solver(
          model, {.integrator = model::Integrator::implicit_step, .iterations = iterations}, 1);
      model::State state = solver->save();
      for (std::size_t i = 0; i < model.vertex_count; ++i)
        state.positions[3 * i] *= 1.2f + 2.0f * state.positions[3 * i + 1];
      solver->load(state);
      TestDrive quiet = quiet_drive(model, 1.0 / 240.0, 4);
      double motion = 0.0, drift = 0.0;
      for (int k = 0; k < 30; ++k) {
        solver->submit(quiet.get(), both);
        const Frame frame = solver->collect();
        Vector3d p = Vector3d::Zero();
        double scale = 0.0;
        for (std::size_t i = 0; i < model.vertex_count; ++i) {
          p += model.mass[i] * triple(frame.velocities, i);
          scale += model.mass[i] * triple(frame.velocities, i).norm();
        }
        motion = std::max(motion, scale);
        drift = std::max(drift, p.norm());
      }
      RecordProperty("drift_beta" + std::to_string(int(beta)) + "_iterations" + std::to_string(iterations),
                     std::to_string(drift / motion));
      EXPECT_LT(drift, (iterations == 20 ? 2e-3 : 1e-4) * motion) << "beta " << beta;
    }
  }
}

// Kinetic energy plus the regions' (1/2) sum_r sum_i w_ir |q_i - g_i^r|^2, with the Oracle's weights.
class Energy {
 public:
  explicit Energy(const Model& model) : model_(model), rest_(rest_points(model)), oracle_(model, implicit) {}
  double operator()(const Frame& frame) const {
    double energy = 0.0;
    std::vector<Vector3d> q(model_.vertex_count);
    for (std::uint32_t i = 0; i < model_.vertex_count; ++i) {
      q[i] = triple(frame.positions, i);
      energy += 0.5 * model_.mass[i] * triple(frame.velocities, i).squaredNorm();
    }
    for (std::uint32_t r = 0; r < model_.vertex_count; ++r) {
      std::vector<std::uint32_t> members(model_.ring.begin() + model_.ring_offset[r],
                                         model_.ring.begin() + model_.ring_offset[r + 1]);
      members.push_back(r);
      double W = 0.0;
      Vector3d c = Vector3d::Zero(), c0 = Vector3d::Zero();
      for (const std::uint32_t i : members) {
        const double w = oracle_.weight(i, r);
        W += w;
        c += w * q[i];
        c0 += w * rest_[i];
      }
      c /= W;
      c0 /= W;
      Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
      double squares = 0.0;
      for (const std::uint32_t i : members) {
        const double w = oracle_.weight(i, r);
        A += w * (q[i] - c) * (rest_[i] - c0).transpose();
        squares += w * ((q[i] - c).squaredNorm() + (rest_[i] - c0).squaredNorm());
      }
      const Eigen::JacobiSVD<Eigen::Matrix3d> svd(A);
      const Vector3d s = svd.singularValues();
      energy += 0.5 * squares - (s[0] + s[1] + (A.determinant() < 0.0 ? -s[2] : s[2]));
    }
    return energy;
  }

 private:
  const Model& model_;
  const Points rest_;
  const Oracle oracle_;
};

// The extremes: 1 Pa and 1 GPa, 0.1 ms and 1/12 s, 1 and 10,000 kg/m^3, a free body that starts stretched and
// moving. It stays finite and gains at most a hundredth of its energy. The full 10,000 steps take minutes, so
// ctest runs 500 of each (FASCICLE_IMPLICIT_STEPS=10000 runs all).
TEST(Implicit, CornersStayFiniteAndGainNoEnergy) {
  const char* asked = std::getenv("FASCICLE_IMPLICIT_STEPS");
  const int steps = asked != nullptr ? std::atoi(asked) : 500;
  for (const double E : {1.0, 1e9})
    for (const double h : {1e-4, 1.0 / 12.0})
      for (const double density : {1.0, 1e4}) {
        const Model model = free_bar(E, 0.7f, density);
        const Energy energy(model);
        const auto solver = make_cpu_solver(model, implicit, 1);
        model::State state = solver->save();
        for (std::size_t i = 0; i < model.vertex_count; ++i) {
          state.positions[3 * i] *= 1.1f + state.positions[3 * i + 1];
          state.velocities[3 * i + 1] = state.positions[3 * i];
        }
        solver->load(state);
        Frame frame;
        frame.positions = state.positions;
        frame.velocities = state.velocities;
        const double before = energy(frame);
        double most = 0.0;
        TestDrive quiet = quiet_drive(model, h, 10);
        for (int k = 0; k < steps / 10; ++k) {
          solver->submit(quiet.get(), both);
          frame = solver->collect();
          const double now = energy(frame);
          ASSERT_TRUE(std::isfinite(now))
              << E << " Pa, " << h << " s, " << density << " kg/m^3, step " << 10 * k;
          most = std::max(most, now);
        }
        EXPECT_LE(most, 1.01 * before) << E << " Pa, " << h << " s, " << density << " kg/m^3";
      }
}

// One free vertex in the middle of a held cube, released on the cube's diagonal, which is an axis of its
// symmetry: when it passes its rest, and its extremes between.
struct Ringing {
  std::vector<double> crossings, extremes;
  double rate() const {  // rad/s
    return std::numbers::pi * double(crossings.size() - 1) / (crossings.back() - crossings.front());
  }
  double decay() const {  // of the amplitude, 1/s
    return std::log(extremes.front() / extremes.back()) * rate() /
           (std::numbers::pi * double(extremes.size() - 1));
  }
};
Ringing ringing_of(double modulus, double h, double viscosity, int substeps) {
  BodyOptions options;
  options.kinematic = [](const Vector3d& p) { return (p - Vector3d::Constant(1.0 / 32)).norm() > 1e-3; };
  const Model model = make_implicit(make_model(kuhn_bar(3, 3, 3, 1.0 / 32), options), modulus);
  const auto solver = make_cpu_solver(
      model, {.integrator = model::Integrator::implicit_step, .iterations = 60, .viscosity = viscosity}, 1);
  model::State state = solver->save();
  std::uint32_t middle = 0;
  while (model.is_kinematic(middle)) ++middle;
  const Vector3d rest = triple(state.positions, middle), way = Vector3d::Ones().normalized();
  constexpr double swing = 1e-3;
  for (int c = 0; c < 3; ++c) state.positions[3 * middle + std::size_t(c)] += float(swing * way[c]);
  solver->load(state);
  TestDrive quiet = quiet_drive(model, h, 1);
  Ringing ringing;
  double before = swing, largest = swing;
  for (int k = 1; k <= substeps; ++k) {
    solver->submit(quiet.get(), both);
    const double now = (triple(solver->collect().positions, middle) - rest).dot(way);
    if ((now < 0.0) != (before < 0.0)) {
      ringing.crossings.push_back((k - now / (now - before)) * h);
      ringing.extremes.push_back(largest);
      largest = 0.0;
    }
    largest = std::max(largest, std::abs(now));
    before = now;
  }
  return ringing;
}

// A viscosity of T seconds takes w^2 T/2 of a swing of w rad/s per second: four times as much from one twice
// as fast. The error of the time step is (w h)^2, a hundredth here, and extremes are sampled.
TEST(Implicit, ViscosityDampsByTheSquareOfTheFrequency) {
  constexpr double h = 1.0 / 1920.0, viscosity = 0.8 * h;
  double slow = 0.0;
  for (const double modulus : {500.0, 2000.0}) {
    const Ringing plain = ringing_of(modulus, h, 0.0, 960), viscous = ringing_of(modulus, h, viscosity, 960);
    ASSERT_GT(viscous.crossings.size(), 6u);
    const double w = plain.rate(), taken = viscous.decay() - plain.decay();
    EXPECT_NEAR(viscous.rate(), w, 0.01 * w);
    EXPECT_NEAR(taken, w * w * viscosity / 2.0, 0.03 * w * w * viscosity / 2.0) << "at " << w << " rad/s";
    if (slow > 0.0) {
      EXPECT_NEAR(taken / slow, 4.0, 0.2);
    }
    slow = taken;
  }
}

// A body that falls undeformed gains h f a substep, viscous or not, and iterations that end early do not slow
// it: they start where it falls to. A viscous one is ahead by viscosity/2 of its velocity. 4 iterations
// resolve the soft body, but not the stiff one, whose place is then off by 2 mm with or without viscosity.
// When they started where a step of BDF2 falls to, the viscous one fell 6 % slower.
TEST(Implicit, ViscosityLeavesAFallAlone) {
  constexpr double h = 1.0 / 480.0, t = 0.5, v = 9.81 * t;
  constexpr int substeps = 8, frames = int(t / (h * substeps));
  struct Fall {
    double viscosity, modulus;
    std::uint32_t iterations;
    double nearness;
  };
  // The first two substeps begin the motion: a few h^2 f.
  constexpr double begun = 2.0 * h * h * 9.81;
  for (const Fall& fall : {Fall{0.0, 2e3, 4, begun}, Fall{0.0, 2e5, 4, 3e-3}, Fall{0.96 * h, 2e3, 4, begun},
                           Fall{0.96 * h, 2e5, 4, 3e-3}, Fall{0.96 * h, 2e5, 20, begun}}) {
    SCOPED_TRACE("viscosity " + std::to_string(fall.viscosity) + ", " + std::to_string(fall.modulus) +
                 " Pa, " + std::to_string(fall.iterations) + " iterations");
    const Model model = free_bar(fall.modulus, 0.0f);
    const auto solver = make_cpu_solver(model,
                                        {.integrator = model::Integrator::implicit_step,
                                         .iterations = fall.iterations,
                                         .viscosity = fall.viscosity},
                                        1);
    const std::vector<float> first = solver->save().positions;
    TestDrive drive = quiet_drive(model, h, substeps, {0, -9.81, 0});
    Frame frame;
    for (int k = 0; k < frames; ++k) {
      solver->submit(drive.get(), both);
      frame = solver->collect();
    }
    for (std::size_t i = 0; i < model.vertex_count; ++i) {
      EXPECT_NEAR(frame.velocities[3 * i + 1], -v, 1e-3 * v);
      EXPECT_NEAR(frame.positions[3 * i + 1] - first[3 * i + 1], -v * (t + fall.viscosity) / 2.0,
                  fall.nearness);
    }
  }
}

// The share of BDF2, and what follows from it. Without viscosity these are BDF2's own numbers, bit by bit.
TEST(Implicit, ViscosityBlendsBackwardEulerIn) {
  constexpr double h = 1.0 / 480.0;
  EXPECT_EQ(model::second_order_share(0.0, h), 1.0);
  EXPECT_NEAR(model::second_order_share(h / 4.0, h), 0.75, 1e-15);
  EXPECT_EQ(model::second_order_share(h, h), 0.0);
  EXPECT_EQ(model::second_order_share(1.0, h), 0.0);
  const Model model = held_bar(1e4);
  const auto step_of = [&](double viscosity, bool has_history) {
    model::SolverOptions options = implicit;
    options.viscosity = viscosity;
    return implicit_step(model, implicit_tables(model, options, h), has_history);
  };
  const shader::ImplicitStep second = step_of(0.0, true), first = step_of(h, true),
                             begun = step_of(0.0, false);
  EXPECT_EQ(second.step, float(2.0 * h / 3.0));
  EXPECT_EQ(second.history, float(1.0 / 3.0));
  EXPECT_EQ(second.skin_history, 0.5f);
  EXPECT_EQ(second.settled, 0.25f);
  EXPECT_EQ(second.start, 0.5f);
  EXPECT_EQ(second.inverse_step, float(1.5 / h));
  for (const shader::ImplicitStep& step : {first, begun}) {
    EXPECT_EQ(step.step, float(h));
    EXPECT_EQ(step.history, 0.0f);
    EXPECT_EQ(step.skin_history, 0.0f);
    EXPECT_EQ(step.settled, 0.0f);
    EXPECT_EQ(step.start, 1.0f);
    EXPECT_EQ(step.inverse_step, float(1.0 / h));
  }
  for (const double viscosity : {-1e-3, std::nan(""), std::numeric_limits<double>::infinity()}) {
    model::SolverOptions options = implicit;
    options.viscosity = viscosity;
    EXPECT_THROW(make_cpu_solver(model, options, 1), std::invalid_argument) << viscosity;
  }
}

// Chebyshev's coefficients, by recurrence and from the polynomials, for soft and stiff bodies.
TEST(Implicit, RelaxationsAreChebyshevs) {
  for (const double stiffest : {0.0, 1e-3, 0.5, 0.99, 0.9999})
    for (const std::uint32_t iterations : {1u, 2u, 5u, 20u, 80u}) {
      const double overshoot = iterations == 5 ? 0.75 : 0.0;
      const std::vector<model::Relaxation> all = model::relaxations(iterations, stiffest, overshoot);
      const cpu_reference::Chebyshev chebyshev(iterations, stiffest, overshoot);
      if (iterations > 1) {
        EXPECT_NEAR(model::extrapolated_share(iterations, stiffest), chebyshev.extrapolated(), 1e-6)
            << iterations << ", " << stiffest;
      }
      ASSERT_EQ(all.size(), iterations);
      for (std::uint32_t k = 0; k < iterations; ++k) {
        EXPECT_NEAR(all[k].omega, chebyshev.omega(k), 1e-6) << k << " of " << iterations << ", " << stiffest;
        EXPECT_NEAR(all[k].gain, chebyshev.gain(k), 1e-6) << k << " of " << iterations << ", " << stiffest;
      }
    }
}

// Model and options must be for the same integrator.
TEST(Implicit, RefusesAModelOfTheOtherIntegrator) {
  const Model plain = make_model(kuhn_bar(2, 1, 1, 0.5));
  EXPECT_THROW(make_cpu_solver(plain, implicit, 1), std::invalid_argument);
  EXPECT_THROW(Oracle(plain, implicit), std::invalid_argument);
  const Model elastic = make_implicit(plain, 1e4);
  EXPECT_THROW(make_cpu_solver(elastic, {}, 1), std::invalid_argument);
  model::State state = make_cpu_solver(plain, {}, 1)->save();
  state.positions_before = state.positions;
  state.velocities_before = state.velocities;
  EXPECT_THROW(make_cpu_solver(plain, {}, 1)->load(state), std::invalid_argument);
}

// The previous substep and its length belong together: solvers would interpret one without the other
// differently.
TEST(Implicit, RefusesAStateWhoseSubstepBeforeIsNotWhole) {
  const Model elastic = make_implicit(make_model(kuhn_bar(2, 1, 1, 0.5)), 1e4);
  const auto solver = make_cpu_solver(elastic, implicit, 1);
  const model::State rest = solver->save();
  EXPECT_NO_THROW(solver->load(rest));
  model::State with = rest;
  with.positions_before = with.positions;
  with.velocities_before = with.velocities;
  EXPECT_THROW(solver->load(with), std::invalid_argument);
  for (const double step :
       {-0.01, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    with.step_before = step;
    EXPECT_THROW(solver->load(with), std::invalid_argument) << step;
  }
  with.step_before = 0.01;
  EXPECT_NO_THROW(solver->load(with));
  model::State without = rest;
  without.step_before = 0.01;
  EXPECT_THROW(solver->load(without), std::invalid_argument);
}

}  // namespace

}  // namespace fascicle::tests::implicit_test
