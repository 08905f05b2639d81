// CpuSolver gives one result for any number of threads, probed or not, resumed or not. It stays near the
// Oracle, and the invariants of the method hold in float.
#include "cpu_reference/solver/cpu_solver.h"

#include <bit>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "cpu_reference/oracle/oracle.h"
#include "host/model/validate.h"
#include "tests/cpu_reference/solver_runs.h"
#include "tests/support/test_models.h"

namespace fascicle::tests::cpu_solver_test {

namespace {

using cpu_reference::make_cpu_solver;
using model::Drive;
using model::Frame;
using model::Model;
using model::Read;
using model::Solver;
using model::Stage;

constexpr Read everything{.positions = true, .velocities = true, .surface = true};
constexpr unsigned random_models = 12;

TEST(CpuSolver, ThreadsAndProbesDoNotMatter) {
  for (unsigned seed = 0; seed < random_models; ++seed) {
    const Model model = random_model(seed);
    struct Watch : model::Probe {
      void on_stage(const model::Where&, std::span<const float>) override { ++stages; }
      int stages = 0;
    } watch;
    const auto one = make_cpu_solver(model, {}, 1), two = make_cpu_solver(model, {}, 2),
               eight = make_cpu_solver(model, {}, 8);
    Sway sway(model);
    for (std::uint64_t k = 1; k <= 20; ++k) {
      const Drive drive = sway.at(k);
      one->submit(drive, everything);
      two->submit(drive, everything);
      eight->submit(drive, everything, &watch);
      const Frame a = one->collect(), b = two->collect(), c = eight->collect();
      ASSERT_EQ(a.positions, b.positions) << "seed " << seed << " frame " << k;
      ASSERT_EQ(a.velocities, b.velocities);
      ASSERT_EQ(a.surface, b.surface);
      ASSERT_EQ(a.positions, c.positions) << "probed, seed " << seed << " frame " << k;
      ASSERT_EQ(a.velocities, c.velocities);
      ASSERT_EQ(a.surface, c.surface);
    }
    EXPECT_EQ(one->save(), eight->save());
    EXPECT_EQ(watch.stages, 20 * (3 * (model.has_skeleton() ? 5 : 4) + 1));
  }
}

TEST(CpuSolver, SavedAndLoadedGoesOnWithTheSameBits) {
  const Model model = random_model(3);
  const auto through = make_cpu_solver(model, {}, 2);
  Sway sway(model);
  for (std::uint64_t k = 1; k <= 10; ++k) through->submit(sway.at(k), {});
  const model::State half = through->save();
  const auto resumed = make_cpu_solver(model, {}, 1);
  resumed->load(half);
  for (std::uint64_t k = 11; k <= 20; ++k) {
    through->submit(sway.at(k), {});
    resumed->submit(sway.at(k), {});
  }
  EXPECT_EQ(through->save(), resumed->save());
  EXPECT_EQ(through->save().frame, 20u);
}

// Rule 5: no stage outputs a denormal, a negative zero or anything else below 2^-40.
TEST(CpuSolver, StagesHandOnNothingBelowTheSnap) {
  struct Check : model::Probe {
    void on_stage(const model::Where& where, std::span<const float> values) override {
      for (const float x : values) {
        const bool zero = std::bit_cast<std::uint32_t>(x) == 0;
        ASSERT_TRUE(zero || std::abs(x) >= 0x1p-40f) << name_of(where.stage) << " " << x;
        zeros += zero;
      }
    }
    std::size_t zeros = 0;
  } check;
  for (unsigned seed = 0; seed < random_models; ++seed) {
    const Model model = random_model(seed);
    const auto solver = make_cpu_solver(model, {}, 1);
    Sway sway(model);
    for (std::uint64_t k = 1; k <= 5; ++k) solver->submit(sway.at(k), {}, &check);
  }
  EXPECT_GT(check.zeros, 0u);
}

// The solver and the Oracle share no arithmetic. Float rounding is 2^-24 for coordinates near 1. Each substep
// adds a few roundings, which a damped body forgets: 20 frames of 3 substeps, 2^-24 x 60 x about 10
// roundings, give 4e-5. The quantisation of shares, 2^-17 of the strain between neighbours, stays below that.
TEST(CpuSolver, StaysNearTheOracle) {
  for (unsigned seed = 0; seed < random_models; ++seed) {
    const Model model = random_model(seed);
    const auto solver = make_cpu_solver(model, {}, 2);
    cpu_reference::Oracle oracle(model, {});
    oracle.load(solver->save());
    Sway sway(model);
    const model::Distance distance = model::distance_to(
        model, *solver, oracle, [&](std::uint64_t k) { return sway.at(k); }, 20);
    EXPECT_LT(distance.largest, 4e-5)
        << "seed " << seed << " frame " << distance.frame << " vertex " << distance.vertex;
    EXPECT_GT(distance.largest, 0.0) << "the two solvers are the same";
  }
}

struct Momentum {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero(), angular = Eigen::Vector3d::Zero();
  double scale = 0.0;  // sum of m |v|
};
Momentum momentum_of(const Model& model, const Frame& frame) {
  Momentum p;
  for (std::size_t i = 0; i < model.vertex_count; ++i) {
    const Eigen::Vector3d x(frame.positions[3 * i], frame.positions[3 * i + 1], frame.positions[3 * i + 2]);
    const Eigen::Vector3d v(frame.velocities[3 * i], frame.velocities[3 * i + 1],
                            frame.velocities[3 * i + 2]);
    p.linear += model.mass[i] * v;
    p.angular += model.mass[i] * x.cross(v);
    p.scale += model.mass[i] * v.norm();
  }
  return p;
}

// A free body that is stretched unevenly and released exerts no net force or torque on itself. Linear
// momentum has only rounding errors: each step's velocity change has an error of 2^-24 relative to alpha (g -
// q)/h, with q near 1 and h 1/240, so 1.4e-5 m/s per vertex and step, with random signs. Over 200 vertices
// and 400 steps this averages below 1e-4 of the motion. Angular momentum adds the rotation's accuracy, 3e-5
// degrees.
TEST(CpuSolver, FreeBodyKeepsItsMomentum) {
  for (const float beta : {0.0f, 0.6f, 1.0f}) {
    BodyOptions options{.alpha = 0.8f, .beta = beta, .fibre = {0.6, 0.8, 0}};
    const Model model = make_model(jittered(kuhn_bar(8, 3, 3, 0.125), 1.0 / 1024, 8, 5), options);
    const auto solver = make_cpu_solver(model, {}, 2);
    model::State state = solver->save();
    for (std::size_t i = 0; i < model.vertex_count; ++i)
      state.positions[3 * i] *= 1.2f + 0.3f * state.positions[3 * i + 1];
    solver->load(state);
    TestDrive quiet = quiet_drive(model, 1.0 / 240.0, 4);
    double motion = 0.0, drift = 0.0, spin = 0.0;
    for (int k = 0; k < 100; ++k) {
      solver->submit(quiet.get(), everything);
      const Momentum p = momentum_of(model, solver->collect());
      motion = std::max(motion, p.scale);
      drift = std::max(drift, p.linear.norm());
      spin = std::max(spin, p.angular.norm());
    }
    EXPECT_LT(drift, 1e-4 * motion) << "beta " << beta;
    EXPECT_LT(spin, 2e-4 * motion) << "beta " << beta;
  }
}

// The control: the weights as printed do push a free body.
TEST(CpuSolver, UnscaledWeightsPushAFreeBody) {
  BodyOptions options{.alpha = 0.8f, .beta = 0.6f, .fibre = {0.6, 0.8, 0}, .momentum_scaled = false};
  const Model model = make_model(jittered(kuhn_bar(8, 3, 3, 0.125), 1.0 / 1024, 8, 5), options);
  const auto solver = make_cpu_solver(model, {}, 2);
  model::State state = solver->save();
  for (std::size_t i = 0; i < model.vertex_count; ++i)
    state.positions[3 * i] *= 1.2f + 0.3f * state.positions[3 * i + 1];
  solver->load(state);
  TestDrive quiet = quiet_drive(model, 1.0 / 240.0, 4);
  double motion = 0.0, drift = 0.0;
  for (int k = 0; k < 100; ++k) {
    solver->submit(quiet.get(), everything);
    const Momentum p = momentum_of(model, solver->collect());
    motion = std::max(motion, p.scale);
    drift = std::max(drift, p.linear.norm());
  }
  EXPECT_GT(drift, 1e-4 * motion);
}

// A free, undamped bar at rest stays within 1.5e-4 of its length in 2,000 substeps. Measured 5.3e-5 to 8.4e-5
// with 3,321 vertices, and 1.4e-4 to 2.8e-4 with 525, as rounding averages out over vertices. This requires a
// translation without a rounding error that repeats in every substep (kernel/region.inc): with the sum q0 + o
// it is 4.3e-4 to 1.8e-3.
TEST(CpuSolver, BarAtRestDoesNotDrift) {
  for (const float beta : {0.0f, 0.7f, 1.0f}) {
    const Model model = make_model(kuhn_bar(40, 8, 8, 0.025), {.alpha = 1.0f, .beta = beta, .damping = 0.0});
    const auto solver = make_cpu_solver(model, {}, 2);
    EXPECT_LT(drift_at_rest(model, *solver), 1.5e-4) << "beta " << beta;
  }
}

// With 2 % damping a substep: measured 1.5e-5; 9.6e-5 with the sum q0 + o, and 3.5e-3 with a goal that sums
// shares times maps instead of differences.
TEST(CpuSolver, DampedBarAtRestDoesNotDrift) {
  const Model model = make_model(kuhn_bar(20, 4, 4, 0.05), {.alpha = 1.0f, .beta = 0.7f, .damping = 12.1});
  const auto solver = make_cpu_solver(model, {}, 2);
  EXPECT_LT(drift_at_rest(model, *solver), 3e-5);
}

// Relative damping: with the skeleton and the origin moving at 5 m/s, the body is the same plus the
// translation. Positions near 1 are rounded to 2^-24 in both runs, at different places: 60 frames of 4
// substeps stay below 2e-5.
TEST(CpuSolver, CarriedSkeletonChangesNothingButTheTranslation) {
  Model model =
      make_model(kuhn_bar(8, 3, 3, 0.125),
                 {.alpha = 0.7f, .damping = 6.0, .kinematic = [](const auto& p) { return p.x() < 0.01; }});
  add_skeleton(model);
  const auto still = make_cpu_solver(model, {}, 1), carried = make_cpu_solver(model, {}, 1);
  const double h = 1.0 / 240.0, speed = 5.0;
  const std::uint32_t substeps = 4;
  TestDrive a = quiet_drive(model, h, substeps, {0, -9.81, 0}),
            b = quiet_drive(model, h, substeps, {0, -9.81, 0});
  model::State moving = carried->save();
  for (std::size_t i = 0; i < model.vertex_count; ++i) moving.velocities[3 * i] = static_cast<float>(speed);
  carried->load(moving);
  double largest = 0.0, origin = 0.0;
  for (int frame = 1; frame <= 60; ++frame) {
    const double at_end = speed * h * substeps * frame, next = std::round(at_end);
    for (std::uint32_t s = 0; s < substeps; ++s)
      for (std::uint32_t j = 0; j < model.joint_count; ++j)
        b.bones[s * model.joint_count + j].xt =
            static_cast<float>(speed * h * (substeps * (frame - 1) + s + 1) - next);
    b.drive.origin = {next, 0, 0};
    b.drive.origin_shift = {static_cast<float>(next - origin), 0, 0};
    origin = next;
    still->submit(a.get(), everything);
    carried->submit(b.get(), everything);
    const Frame p = still->collect(), q = carried->collect();
    for (std::size_t k = 0; k < p.positions.size(); ++k) {
      const double back = k % 3 == 0 ? at_end - next : 0.0;
      largest = std::max(largest, std::abs(static_cast<double>(q.positions[k]) - back -
                                           static_cast<double>(p.positions[k])));
    }
  }
  EXPECT_LT(largest, 2e-5);
}

// mueller2016 reaches the same rest shape: on a settled body both rotations agree to the float accuracy of
// the blend.
TEST(CpuSolver, BothRotationsSettleAlike) {
  const Model model =
      make_model(kuhn_bar(8, 3, 3, 0.125),
                 {.alpha = 1.0f, .damping = 20.0, .kinematic = [](const auto& p) { return p.x() < 0.01; }});
  const auto qcp = make_cpu_solver(model, {.rotation = model::Rotation::qcp}, 1);
  const auto mueller = make_cpu_solver(model, {.rotation = model::Rotation::mueller2016}, 1);
  TestDrive drive = quiet_drive(model, 1.0 / 240.0, 4, {0, -9.81, 0});
  Frame a, b;
  for (int k = 0; k < 600; ++k) {
    qcp->submit(drive.get(), everything);
    mueller->submit(drive.get(), everything);
    a = qcp->collect();
    b = mueller->collect();
  }
  double largest = 0.0, moved = 0.0;
  for (std::size_t k = 0; k < a.positions.size(); ++k) {
    largest = std::max(largest, static_cast<double>(std::abs(a.positions[k] - b.positions[k])));
    moved = std::max(moved, static_cast<double>(std::abs(a.positions[k] - model.rest[k])));
  }
  EXPECT_LT(largest, 1e-4 * moved + 1e-5);
  EXPECT_GT(moved, 1e-3);
}

TEST(CpuSolver, RefusesWhatDoesNotFit) {
  const Model model = make_model(kuhn_bar(2, 1, 1, 0.5));
  const auto solver = make_cpu_solver(model, {}, 1);
  EXPECT_THROW(solver->collect(), std::logic_error);
  TestDrive drive = quiet_drive(model, 1.0 / 60.0);
  drive.drive.substeps = 0;
  EXPECT_THROW(solver->submit(drive.drive, {}), std::invalid_argument);
  model::State state = solver->save();
  state.positions.pop_back();
  EXPECT_THROW(solver->load(state), std::invalid_argument);
}

}  // namespace

}  // namespace fascicle::tests::cpu_solver_test
