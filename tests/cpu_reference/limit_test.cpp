// Crushed flesh pushes back. The solvers match the Oracle's formulas, and its gradients match the volume. A
// free body exerts no net force or torque on itself. A load that crushes flesh without limits does not crush
// it with them. Where nothing is crushed, no bit changes.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "cpu_reference/oracle/oracle.h"
#include "cpu_reference/oracle/oracle_limit.h"
#include "cpu_reference/solver/cpu_solver.h"
#include "tests/support/bar_model.h"
#include "tests/support/limit_models.h"
#include "tests/support/test_models.h"

namespace fascicle::tests::limit_test {

namespace {

using cpu_reference::make_cpu_solver;
using cpu_reference::Oracle;
using cpu_reference::Simd;
using Eigen::Vector3d;
using model::Model;
using model::State;

constexpr model::SolverOptions implicit{.integrator = model::Integrator::implicit_step};
constexpr double kept = 0.3;

Vector3d triple(const std::vector<float>& values, std::uint32_t i) {
  return Vector3d(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
}

// 0.19 m high; E in Pa; with `held`, the lowest vertices are kinematic.
Model column(double E, bool held, double share = kept) {
  BodyOptions options;
  options.damping = 12.0;
  if (held) options.kinematic = [](const Vector3d& p) { return p.y() < 1e-3; };
  Model model =
      make_implicit(make_model(jittered(kuhn_bar(2, 6, 2, 1.0 / 32), 1.0 / 4096, 8, 3), options), E);
  if (share > 0.0) add_limits(model, share);
  return model;
}

// The smallest volume of any tetrahedron, relative to its volume at rest.
double least_volume(const Model& model, const std::vector<float>& positions) {
  double least = 1.0;
  for (std::size_t t = 0; t < model.tetrahedron.size(); t += 4) {
    const auto six = [&](const std::vector<float>& at) {
      const Vector3d o = triple(at, model.tetrahedron[t]);
      return (triple(at, model.tetrahedron[t + 1]) - o)
          .cross(triple(at, model.tetrahedron[t + 2]) - o)
          .dot(triple(at, model.tetrahedron[t + 3]) - o);
    };
    least = std::min(least, six(positions) / six(model.rest));
  }
  return least;
}

State after_load(const Model& model, model::Solver& solver, double load, int frames) {
  TestDrive drive = quiet_drive(model, 1.0 / 240.0, 4, {0.0, -load, 0.0});
  for (int k = 0; k < frames; ++k) solver.submit(drive.get(), {});
  return solver.save();
}

// A body pressed to a third of its height, slightly bent, and moving.
State crushed(const Model& model, State state) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    state.positions[3 * i + 1] *= 0.3f;
    state.positions[3 * i] += 0.2f * state.positions[3 * i + 1];
    for (std::size_t k = 0; k < 3; ++k) {
      state.positions[3 * i + k] += float(1e-3 * normal(random));
      state.velocities[3 * i + k] += float(0.1 * normal(random));
    }
  }
  return state;
}

TEST(Limit, TheModelKeepsItsPromises) {
  EXPECT_NO_THROW(check_model(column(3e3, true)));
  EXPECT_NO_THROW(check_model(column(3e3, false)));
}

// Central differences of a cubic that is linear in each coordinate: exact except for rounding.
TEST(Limit, TheOraclesGradientsAreThoseOfTheVolume) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const std::array<std::uint32_t, 4> corner{2, 0, 3, 1};
  for (int trial = 0; trial < 20; ++trial) {
    cpu_reference::Points q(4);
    for (Vector3d& p : q) p = Vector3d(normal(random), normal(random), normal(random));
    const auto found = cpu_reference::volume_gradients(q, corner);
    const Vector3d o = q[2];
    EXPECT_NEAR(found.volume, (q[0] - o).cross(q[3] - o).dot(q[1] - o) / 6.0, 1e-12);
    for (std::size_t k = 0; k < 4; ++k)
      for (int axis = 0; axis < 3; ++axis) {
        const auto volume_at = [&](double step) {
          cpu_reference::Points moved = q;
          moved[corner[k]][axis] += step;
          return cpu_reference::volume_gradients(moved, corner).volume;
        };
        EXPECT_NEAR(found.by[k][axis], (volume_at(0.5) - volume_at(-0.5)), 1e-12);
      }
  }
}

// By hand: one free corner above a held triangle, pressed flat. The gradient is the triangle's area over 3,
// along the normal, so a pass reaches the limit except for a hundredth that bounds the step. As it had no
// volume at the beginning of the substep, it opens by all of the missing volume, or by less in a short step.
TEST(Limit, ACornerOverAHeldTriangleIsLiftedToItsLeastHeight) {
  Model model = make_model(regular_tetrahedron());
  for (const std::uint32_t i : {1u, 2u, 3u}) make_kinematic(model, i);
  model = make_implicit(model, 1.0);
  add_limits(model, 0.5);
  const State rest = make_cpu_solver(model, implicit, 1)->save();
  const Vector3d centre =
      (triple(rest.positions, 1) + triple(rest.positions, 2) + triple(rest.positions, 3)) / 3.0;
  const double top = (triple(rest.positions, 0) - centre).norm();
  for (const double h : {1e-2, 1e-3, 1e-4}) {
    const auto solver = make_cpu_solver(model, implicit, 1);
    State state = rest;
    for (std::size_t k = 0; k < 3; ++k) state.positions[k] = float(centre[int(k)]);
    solver->load(state);
    TestDrive drive = quiet_drive(model, h);
    solver->submit(drive.get(), {});
    const State lifted = solver->save();
    // The tolerance covers what the passes leave and the effect of the flesh's 1 Pa in the step.
    const double way = std::min(1.0, 240.0 * h) * 0.5 * top;
    EXPECT_NEAR((triple(lifted.positions, 0) - centre).norm(), way, 1e-3 * top) << h;
    // So the speed is bounded for any step length, and flesh that skinning crushes suddenly does not burst.
    EXPECT_NEAR(triple(lifted.velocities, 0).norm(), way / h, 0.01 * way / h) << h;
  }
}

// A column between two plates comes to rest, however short the substeps are. Rounding leaves 2e-5 m/s at 1440
// substeps a second, and about 5e-4 if a tetrahedron is just at its limit. When limits overshot the missing
// volume by half, it trembled at 0.02 to 0.4 m/s. The control: it moves while it is being pressed.
TEST(Limit, FleshThatIsPressedAndHeldComesToRest) {
  for (const float pressed : {0.25f, 0.4f, 0.6f})
    for (const double rate : {240.0, 1440.0}) {
      SCOPED_TRACE(rate);
      Model model = column(3e3, true);
      for (std::uint32_t i = 0; i < model.vertex_count; ++i)
        if (model.rest[3 * i + 1] > 0.18f) make_kinematic(model, i);
      model = make_implicit(model, 3e3);
      add_limits(model, kept);
      const auto solver = make_cpu_solver(model, implicit, 2);
      State state = solver->save();
      for (std::uint32_t i = 0; i < model.vertex_count; ++i) state.positions[3 * i + 1] *= pressed;
      solver->load(state);
      const auto speed_after = [&](double seconds) {
        TestDrive drive = quiet_drive(model, 1.0 / rate, static_cast<std::uint32_t>(rate * seconds));
        solver->submit(drive.get(), {});
        const State now = solver->save();
        double sum = 0.0;
        for (std::uint32_t i = 0; i < model.vertex_count; ++i) sum += triple(now.velocities, i).squaredNorm();
        return std::sqrt(sum / model.vertex_count);
      };
      EXPECT_GT(speed_after(0.025), 0.05);
      EXPECT_LT(speed_after(2.0), 2e-3);
      EXPECT_LT(least_volume(model, solver->save().positions), 1.01 * kept) << "no limit is active";
    }
}

// Metres, for a column of 0.19 that is crushed to a third. Rounding decides which tetrahedra lack volume,
// which amplifies it. Three frames of four substeps; the load itself moves vertices a hundred times as far.
TEST(Limit, FollowsTheOracle) {
  const Model model = column(3e3, true);
  const auto solver = make_cpu_solver(model, implicit, 2);
  Oracle oracle(model, implicit);
  const State a = after_load(model, *solver, 100.0, 3), b = after_load(model, oracle, 100.0, 3);
  double largest = 0.0, moved = 0.0;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    largest = std::max(largest, (triple(a.positions, i) - triple(b.positions, i)).norm());
    moved = std::max(moved, (triple(a.positions, i) - triple(model.rest, i)).norm());
  }
  EXPECT_GT(moved, 0.05);
  EXPECT_LT(largest, 5e-4);
}

// Tissue under four and ten times its weight; without limits, ten times its weight turns it inside out.
TEST(Limit, TissueUnderALoadKeepsItsVolume) {
  for (const double load : {40.0, 100.0}) {
    const Model model = column(3e3, true), without = column(3e3, true, 0.0);
    const State state = after_load(model, *make_cpu_solver(model, implicit, 2), load, 60);
    const State control = after_load(without, *make_cpu_solver(without, implicit, 2), load, 60);
    EXPECT_GT(least_volume(model, state.positions), 0.0) << load;
    if (load > 50.0) {
      EXPECT_LT(least_volume(without, control.positions), 0.0);
    }
  }
}

// A body turned inside out opens again.
TEST(Limit, FlatTetrahedraOpen) {
  const Model model = column(3e3, true);
  const auto solver = make_cpu_solver(model, implicit, 1);
  State state = solver->save();
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    if (!model.is_kinematic(i)) state.positions[3 * i + 1] *= -0.1f;
  EXPECT_LT(least_volume(model, state.positions), -0.05);
  solver->load(state);
  EXPECT_GT(least_volume(model, after_load(model, *solver, 0.0, 30).positions), 0.0);
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

// The change of a crushed free body's momenta in a frame, relative to the motion as it opens.
double change_of_momentum(const Model& model, model::Solver& solver) {
  const State start = crushed(model, solver.save());
  solver.load(start);
  const State end = after_load(model, solver, 0.0, 1);
  const Momentum before = momentum_of(model, start), after = momentum_of(model, end);
  return std::max((after.linear - before.linear).norm(), (after.angular - before.angular).norm()) /
         after.size;
}

// Undamped. The error is the iterations' tolerance, to which limits add nothing. The control: some vertices
// respond to limits as if they were lighter.
TEST(Limit, AFreeBodyKeepsItsMomenta) {
  Model model = column(3e3, false);
  model.layers[0].damping = 0.0;
  EXPECT_LT(change_of_momentum(model, *make_cpu_solver(model, implicit, 1)), 2e-3);
  for (std::uint32_t i = 0; i < model.vertex_count; i += 3) model.mobility[i] *= 4.0f;
  EXPECT_GT(change_of_momentum(model, *make_cpu_solver(model, implicit, 1)), 2e-2);
}

TEST(Limit, WhereNothingIsCrushedNoBitChanges) {
  const Model model = column(2e4, true), without = column(2e4, true, 0.0);
  EXPECT_EQ(after_load(model, *make_cpu_solver(model, implicit, 2), 9.81, 10),
            after_load(without, *make_cpu_solver(without, implicit, 2), 9.81, 10));
  // The control: under a crushing load they differ.
  EXPECT_NE(after_load(model, *make_cpu_solver(model, implicit, 2), 500.0, 10),
            after_load(without, *make_cpu_solver(without, implicit, 2), 500.0, 10));
}

TEST(Limit, LanesThreadsAndSavingHaveTheScalarBits) {
  const Model model = column(3e3, true);
  const State scalar = after_load(model, *make_cpu_solver(model, implicit, 1, Simd::scalar), 100.0, 4);
  for (const Simd simd : cpu_reference::available_simd())
    for (const unsigned threads : {1u, 3u}) {
      const auto solver = make_cpu_solver(model, implicit, threads, simd);
      const State half = after_load(model, *solver, 100.0, 2);
      const auto resumed = make_cpu_solver(model, implicit, threads, simd);
      resumed->load(half);
      EXPECT_EQ(after_load(model, *resumed, 100.0, 2), scalar) << name_of(simd);
    }
}

// The bar of the GPU tests is crushed: without limits it moves differently.
TEST(Limit, TheBarThatOtherTestsBendIsCrushed) {
  const Model model = make_bar({.skeleton = true, .implicit = true, .limits = true}),
              without = make_bar({.skeleton = true, .implicit = true});
  const auto bent = [](const Model& m) {
    const auto solver = make_cpu_solver(m, implicit, 1);
    BarMotion motion(m, 3);
    for (std::uint64_t k = 1; k <= 3; ++k) solver->submit(motion.drive(k), {});
    return solver->save();
  };
  check_model(model);
  EXPECT_NE(bent(model).positions, bent(without).positions);
}

}  // namespace

}  // namespace fascicle::tests::limit_test
