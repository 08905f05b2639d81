// How far flesh is expected to swing, compared with how far it does.
#include "host/bake/expected_look.h"

#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "cpu_reference/solver/cpu_solver.h"
#include "host/bake/look.h"
#include "host/drive/lead_in.h"
#include "host/rig/smooth_clip.h"
#include "tests/drive/bending_bar.h"
#include "tests/support/test_models.h"

namespace fascicle::tests {
namespace {

using Eigen::Vector3d;

constexpr double acceleration = 9.6;  // m/s^2

// Thrown along y with constant acceleration. The bar's axis is kinematic; its flesh is 0.1 m deep.
BendingBar thrown_bar(double damping) {
  BendingBar bar = bending_bar(1.0);
  std::vector<RootKey> keys;
  for (int k = 0; k <= 24; ++k) {
    const double t = k / 24.0;
    keys.push_back({t, Vector3d(0, 0.5 * acceleration * t * t, 0)});
  }
  bar.character().clips.push_back(rig::smooth_clip({"throw", 1.0, {root_channel(keys)}}, false, 0.0, 1.0));
  for (model::Layer& layer : bar.model.layers) layer.damping = damping;
  return bar;
}

BendingBar elastic_bar(double youngs_modulus, double damping = 12.0) {
  BendingBar bar = thrown_bar(damping);
  bar.model = make_implicit(bar.model, youngs_modulus);
  return bar;
}

bake::ExpectedLook expected(const BendingBar& bar) {
  drive::DriveSource drives(bar.scene, bar.model);
  return bake::expected_look(bar.scene, bar.model, bake::look_body_of(bar.scene, bar.model).value(), drives)
      .value();
}

// The largest score of LookMeasure::distance.
double measured(const BendingBar& bar) {
  drive::DriveSource drives(bar.scene, bar.model);
  const auto solver = cpu_reference::make_cpu_solver(
      bar.model,
      {.integrator =
           bar.model.is_implicit() ? model::Integrator::implicit_step : model::Integrator::explicit_step},
      2);
  solver->load(drive::lead_in(bar.scene, bar.model, drives, *solver).state);
  const bake::LookBody body = bake::look_body(bar.model, &std::get<rig::Character>(bar.scene.geometry));
  bake::Look look(bar.model, body, bar.scene.fps);
  double largest = 0.0;
  for (std::uint64_t k = 1; k <= scene::cycle_frames(bar.scene); ++k) {
    solver->submit(drives.drive(k), {.positions = true, .skinned = true});
    const auto of = look.of(solver->collect()).of;
    largest = std::max(largest, of[static_cast<std::size_t>(bake::LookMeasure::distance)].score);
  }
  return largest;
}

// The estimate shears a column, one of several ways in which flesh yields. It is within a factor of two of
// the bake over two decades of stiffness.
TEST(ExpectedLook, IsWhatABakeComesTo) {
  for (const double youngs_modulus : {3e3, 3e4, 3e5}) {
    const BendingBar bar = elastic_bar(youngs_modulus);
    const double baked = measured(bar), score = expected(bar).score;
    EXPECT_GT(score, 0.5 * baked) << youngs_modulus;
    EXPECT_LT(score, 2.0 * baked) << youngs_modulus;
  }
}

TEST(ExpectedLook, IsWhatAnExplicitBakeComesTo) {
  BendingBar bar = thrown_bar(12.0);
  const double baked = measured(bar), score = expected(bar).score;
  EXPECT_GT(score, 0.5 * baked);
  EXPECT_LT(score, 2.0 * baked);
}

// Under a steady push flesh comes to rest at a c, and c is proportional to 1/E. With this damping, 1 % of the
// oscillation remains.
TEST(ExpectedLook, GoesWithTheStiffnessWhereThePushIsSteady) {
  const double soft = expected(elastic_bar(2e4, 60.0)).score;
  const double stiff = expected(elastic_bar(4e4, 60.0)).score;
  EXPECT_NEAR(soft, 2.0 * stiff, 0.03 * soft);
  // Flesh that feels half of the acceleration scores half.
  BendingBar half = elastic_bar(2e4, 60.0);
  half.model.carried.assign(half.model.vertex_count, 0.5f);
  EXPECT_NEAR(expected(half).score, 0.5 * soft, 1e-6 * soft);
}

// The advice is right: flesh that much stiffer scores at most 1; flesh a fifth softer than that does not.
TEST(ExpectedLook, SaysHowMuchStifferWouldDo) {
  const double youngs_modulus = 500.0;
  const bake::ExpectedLook look = expected(elastic_bar(youngs_modulus));
  ASSERT_GT(look.score, 1.0);
  EXPECT_GT(look.stiffer, 1.0);
  EXPECT_LE(expected(elastic_bar(youngs_modulus * look.stiffer)).score, 1.0 + 1e-9);
  EXPECT_GT(expected(elastic_bar(youngs_modulus * look.stiffer / 1.26)).score, 1.0);
  const BendingBar bar = elastic_bar(youngs_modulus);
  const std::string text = bake::expected_look_warning(bar.scene, bar.model, look);
  EXPECT_NE(text.find("layers.body"), std::string::npos) << text;
  EXPECT_NE(text.find("times stiffer"), std::string::npos) << text;
  EXPECT_EQ(expected(elastic_bar(1e5)).stiffer, 1.0);
}

// Gravity also acts on flesh that does not feel the skeleton's acceleration: the bar falls over while it is
// thrown.
TEST(ExpectedLook, GivesGravityItsFullWeight) {
  BendingBar bar = elastic_bar(2e4, 60.0);
  bar.model.carried.assign(bar.model.vertex_count, 1.0f);
  EXPECT_EQ(expected(bar).score, 0.0);
  // A shape that is at rest without gravity feels all of it.
  bar.scene.motion.rest = scene::Rest::weightless;
  bar.scene.gravity = Vector3d(0, -acceleration, 0);
  EXPECT_NEAR(expected(bar).score, expected(elastic_bar(2e4, 60.0)).score, 0.1 * expected(bar).score);
}

// A few frames that start from the skinned pose predict the whole bake.
TEST(ExpectedLook, TriedFramesLookLikeTheBakes) {
  for (const double youngs_modulus : {500.0, 3e4}) {
    const BendingBar bar = elastic_bar(youngs_modulus);
    const auto solver =
        cpu_reference::make_cpu_solver(bar.model, {.integrator = model::Integrator::implicit_step}, 2);
    drive::DriveSource drives(bar.scene, bar.model);
    const std::uint64_t frame = scene::cycle_frames(bar.scene) / 2;
    const bake::LookBody body = bake::look_body_of(bar.scene, bar.model).value();
    const bake::TriedLook tried =
        bake::try_look(bar.scene, bar.model, body, drives, *solver, bake::frames_to_try(bar.scene, frame));
    EXPECT_LT(tried.first, frame);
    EXPECT_GT(tried.last, frame);
    EXPECT_EQ(tried.worst.score > 1.0, measured(bar) > 1.0) << youngs_modulus;
    EXPECT_EQ(tried.frames_over > 0, tried.worst.score > 1.0);
    if (tried.worst.score > 1.0) {
      EXPECT_NE(bake::tried_look_warning(bar.scene, tried).find("tried before the bake"), std::string::npos);
    }
    EXPECT_EQ(solver->save().positions, drives.initial_state().positions) << "the solver's state is restored";
  }
}

TEST(ExpectedLook, TriedFramesCanBeStopped) {
  const BendingBar bar = elastic_bar(500.0);
  const auto solver =
      cpu_reference::make_cpu_solver(bar.model, {.integrator = model::Integrator::implicit_step}, 2);
  drive::DriveSource drives(bar.scene, bar.model);
  int asked = 0;
  const auto twice = [&](const bake::TriedLook& tried) {
    EXPECT_LT(tried.first, tried.last);
    return ++asked <= 2;
  };
  bake::try_look(bar.scene, bar.model, bake::look_body_of(bar.scene, bar.model).value(), drives, *solver,
                 bake::frames_to_try(bar.scene, scene::cycle_frames(bar.scene) / 2), twice);
  EXPECT_EQ(asked, 3);
  EXPECT_EQ(solver->save().positions, drives.initial_state().positions);
}

// It may be stopped in each frame, and at each step towards the remedy.
TEST(ExpectedLook, StopsWhereItIsTold) {
  const BendingBar bar = elastic_bar(500.0);
  ASSERT_GT(expected(bar).stiffer, 1.25);
  const auto asked = [&](int most) {
    drive::DriveSource drives(bar.scene, bar.model);
    int count = 0;
    const auto look =
        bake::expected_look(bar.scene, bar.model, bake::look_body_of(bar.scene, bar.model).value(), drives,
                            [&] { return ++count < most; });
    return std::pair{count, look.has_value()};
  };
  const auto [all, has_all] = asked(1 << 20);
  EXPECT_TRUE(has_all);
  EXPECT_GT(all, static_cast<int>(scene::cycle_frames(bar.scene)) + 2) << "frames, joints and steps";
  for (const int most : {1, all / 2, all - 1, all}) {
    const auto [count, has_look] = asked(most);
    EXPECT_FALSE(has_look) << most;
    EXPECT_LE(count, most + 1) << most;
  }
}

// Trying 0.3 s makes no sense if a frame is longer.
TEST(ExpectedLook, LongFramesAreNotTried) {
  scene::Scene scene = elastic_bar(500.0).scene;
  EXPECT_TRUE(bake::can_try_look(scene));
  scene.fps = 4.9;
  EXPECT_FALSE(bake::can_try_look(scene));
}

TEST(ExpectedLook, AsksFreeFleshAndASkeleton) {
  BendingBar bar = elastic_bar(1e4);
  for (std::uint32_t i = 0; i < bar.model.vertex_count; ++i) make_kinematic(bar.model, i);
  drive::DriveSource still(bar.scene, bar.model);
  const bake::LookBody body = bake::look_body_of(bar.scene, bar.model).value();
  EXPECT_FALSE(bake::expected_look(bar.scene, bar.model, body, still).has_value());
}

}  // namespace
}  // namespace fascicle::tests
