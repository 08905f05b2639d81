// The effect of the skeleton's motion on flesh: gravity in rotated frames, rest, prerolls, cuts, loops.
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "cpu_reference/oracle/oracle.h"
#include "cpu_reference/solver/cpu_solver.h"
#include "host/drive/drive_source.h"
#include "host/drive/lead_in.h"
#include "host/drive/pose_blend.h"
#include "host/model/validate.h"
#include "tests/drive/bending_bar.h"

namespace fascicle::tests {

namespace {

using Eigen::Vector3d;
using rig::Interpolation;

double rms_speed(const model::Model& model, const model::State& state) {
  double sum = 0.0;
  std::size_t count = 0;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    if (model.is_kinematic(i)) continue;
    for (std::size_t c = 0; c < 3; ++c)
      sum += std::pow(model.unit * double{state.velocities[3 * std::size_t{i} + c]}, 2);
    ++count;
  }
  return std::sqrt(sum / static_cast<double>(count));
}

// A second of swinging and moving along: the base motion of the tests below.
BendingBar swinging(double seconds = 1.0) {
  BendingBar bar = bending_bar(seconds);
  rig::Clip clip{"swing", seconds, {}};
  std::vector<double> times, angles;
  for (int k = 0; k <= 24; ++k) {
    times.push_back(seconds * k / 24.0);
    angles.push_back(0.5 * std::sin(2.0 * std::numbers::pi * k / 24.0));
  }
  clip.channels.push_back(turn_channel(1, times, angles));
  bar.character().clips.push_back(clip);
  return bar;
}

// f_i = m_i (g - R_i g) vanishes in the bind pose. A thousand frames; float rounding of positions near 1 is
// 6e-8.
TEST(Gravity, SculptedBindPoseIsAtRest) {
  BendingBar bar = bending_bar(20.0);
  const Walked sculpted = run(bar, 1000);
  EXPECT_LT(furthest(sculpted.positions.back(), sculpted.positions.front()), 1e-6 * bar_height);
  // The control: under full gravity the same body sags.
  bar.scene.motion.rest = scene::Rest::weightless;
  const Walked weightless = run(bar, 60);
  EXPECT_GT(furthest(weightless.positions.back(), weightless.positions.front()), 1e-3 * bar_height);
}

// A body on its side feels g - R g: in its own frame, that is what an unrotated body feels under R^T g - g.
// Positions near 1, rounded by 6e-8 per substep over 480 damped substeps.
TEST(Gravity, ChangesWithTheBodysFrame) {
  const double angle = 2.0;
  BendingBar lying = bending_bar(1.0);
  lying.character().clips.push_back({"lie", 1.0, {turn_channel(0, {0.0}, {angle})}});
  const Walked turned = run(lying, 60);

  BendingBar upright = bending_bar(1.0);
  const Eigen::AngleAxisd R(angle, Vector3d::UnitZ());
  const Vector3d g(0, -9.81, 0);
  upright.scene.gravity = R.inverse() * g - g;
  upright.scene.motion.rest = scene::Rest::weightless;
  const Walked straight = run(upright, 60);
  const Vector3d pivot(0, 0.1, 0.1);
  double largest = 0.0, moved = 0.0;
  for (std::size_t i = 0; i < straight.positions.back().size(); ++i) {
    const Vector3d expected = R * (straight.positions.back()[i] - pivot) + pivot;
    largest = std::max(largest, (turned.positions.back()[i] - expected).norm());
    moved = std::max(moved, (straight.positions.back()[i] - straight.positions.front()[i]).norm());
  }
  EXPECT_LT(largest, 1e-5 * bar_height);
  EXPECT_GT(moved, 1e-3 * bar_height);
}

// A clip that holds a bent pose: once at rest, nothing creeps, jitters or blows up.
TEST(Gravity, HeldStillNothingMoves) {
  for (const scene::Rest rest : {scene::Rest::sculpted, scene::Rest::weightless}) {
    BendingBar bar = bending_bar(20.0);
    bar.scene.motion.rest = rest;
    bar.character().clips.push_back({"bent", 1.0, {turn_channel(1, {0.0}, {1.0})}});
    const Walked result = run(bar, 1200);
    EXPECT_LT(rms_speed(bar.model, result.last), 1e-3);
    EXPECT_LT(furthest(result.positions[1200], result.positions[200]), 1e-4 * bar_height);
    EXPECT_GT(furthest(result.positions[200], result.skinned[200]), 1e-3 * bar_height) << "it hangs";
  }
}

// The blend from the bind pose: rigid at its start, the first pose at its end, and limbs of constant length
// in between.
TEST(Preroll, GoesFromTheBindPoseInThePlaceOfTheFirstPose) {
  BendingBar bar = bending_bar(1.0);
  bar.character().clips.push_back(
      {"far",
       1.0,
       {root_channel({{0.0, {5, 1, 0}}}), turn_channel(0, {0.0}, {0.7}), turn_channel(1, {0.0}, {1.2})}});
  bar.scene.motion.preroll = 0.5;
  drive::DriveSource drives(bar.scene, bar.model);
  EXPECT_EQ(drives.preroll_frames(), 30u);
  const model::State first = drives.preroll_state();
  const auto point = [&](const model::State& state, std::size_t i) {
    return Vector3d(state.positions[3 * i], state.positions[3 * i + 1], state.positions[3 * i + 2]);
  };
  const auto rest = [&](std::size_t i) {
    return Vector3d(bar.model.rest[3 * i], bar.model.rest[3 * i + 1], bar.model.rest[3 * i + 2]);
  };
  const Eigen::AngleAxisd R(0.7, Vector3d::UnitZ());
  const Vector3d pivot(0, 0.1, 0.1), place(5, 1.1, 0.1);
  for (std::size_t i = 0; i < bar.model.vertex_count; ++i) {
    const Vector3d expected = R * (rest(i) - pivot) + place;
    const Vector3d frame_origin(first.origin[0], first.origin[1], first.origin[2]);
    ASSERT_LT((point(first, i) + frame_origin - expected).norm(), 2e-6)
        << "rounding of positions of a few metres";
  }
  // The last pose of the preroll is that of frame 0.
  const model::Drive last = drives.preroll_drive(30);
  const std::vector<shader::Bone> end(last.bones.end() - 2, last.bones.end());
  const model::Drive still = drives.settle_drive();
  for (std::size_t j = 0; j < 2; ++j) {
    EXPECT_NEAR(end[j].xx, still.bones[j].xx, 1e-6f);
    EXPECT_NEAR(end[j].yx, still.bones[j].yx, 1e-6f);
    EXPECT_NEAR(end[j].xt, still.bones[j].xt, 1e-6f);
  }
  for (const double share : {0.0, 0.3, 0.5, 1.0}) {
    const auto pose = drive::blend_from_bind(
        bar.character(), 0,
        {Eigen::Matrix4d::Identity(), Eigen::Matrix4d(bar.character().skeleton[1].rest_local)}, share);
    EXPECT_NEAR((pose[1] - pose[0]).topRightCorner(3, 1).norm(), 0.3, 1e-12);
  }
}

// Flesh that has settled is not thrown by the first frame.
TEST(Preroll, LeavesNoJumpAtFrameOne) {
  BendingBar bar = bending_bar(1.0);
  bar.character().clips.push_back({"bent", 1.0, {turn_channel(1, {0.0}, {1.8})}});
  const Walked without = run(bar, 180);
  bar.scene.motion.preroll = 0.5;
  bar.scene.motion.settle = 4.0;
  const Walked with = run(bar, 180);
  EXPECT_LT(furthest(with.positions[1], with.positions[0]), 1e-4 * bar_height);
  EXPECT_GT(furthest(without.positions[1], without.positions[0]),
            20 * furthest(with.positions[1], with.positions[0]));
  // Both end at the rest position of the pose.
  EXPECT_LT(furthest(with.positions[180], without.positions[180]), 1e-3 * bar_height);
}

TEST(Settle, EndsWhenTheFleshIsStill) {
  BendingBar bar = bending_bar(1.0);
  bar.character().clips.push_back({"bent", 1.0, {turn_channel(1, {0.0}, {1.0})}});
  bar.scene.motion.settle = 30.0;
  drive::DriveSource drives(bar.scene, bar.model);
  const auto solver = cpu_reference::make_cpu_solver(bar.model, {}, 2);
  const drive::LeadIn led = drive::lead_in(bar.scene, bar.model, drives, *solver);
  EXPECT_GT(led.summary.settle_frames, 10u);
  EXPECT_LT(led.summary.settle_frames, 600u);
  ASSERT_TRUE(led.summary.settled_speed.has_value());
  EXPECT_LT(*led.summary.settled_speed, scene::still_speed);
  EXPECT_EQ(led.state.frame, 0u);
  EXPECT_LT(rms_speed(bar.model, led.state), scene::still_speed);
}

// A clip that also moves at 5 m/s gives the same frames plus the translation, to 1e-4 of the height.
TEST(Carried, AtConstantSpeedBakesTheSameFrames) {
  const BendingBar standing = swinging();
  BendingBar riding = swinging();
  riding.character().clips[0].channels.push_back(root_channel({{0.0, {0, 0, 0}}, {1.0, {5, 0, 0}}}));
  const Walked a = run(standing, 60), b = run(riding, 60);
  for (std::size_t k = 0; k <= 60; ++k)
    ASSERT_LT(furthest(b.positions[k], a.positions[k], Vector3d(5.0 * static_cast<double>(k) / 60.0, 0, 0)),
              1e-4 * bar_height)
        << "frame " << k;
  EXPECT_GT(furthest(a.positions[30], a.skinned[30]), 1e-3 * bar_height) << "the flesh does lag";
}

// A teleport by 100 m in the middle of the swing, detected by its size: before and after it the flesh is
// where it would be without it, carried along.
TEST(Cut, ATeleportCarriesTheFlesh) {
  const BendingBar staying = swinging();
  BendingBar jumping = swinging();
  const Vector3d away(80, 0, 60);
  jumping.character().clips[0].channels.push_back(
      root_channel({{0.0, {0, 0, 0}}, {0.504, away}}, Interpolation::step));
  const Walked a = run(staying, 60), b = run(jumping, 60);
  for (std::size_t k = 0; k <= 60; ++k) {
    const bool jumped = static_cast<double>(k) / 60.0 >= 0.504;
    ASSERT_LT(furthest(b.positions[k], a.positions[k], jumped ? away : Vector3d::Zero()), 1e-4 * bar_height)
        << "frame " << k;
  }
}

// The same jump between keys of a linear channel 1/24 s apart, as exporters write it: it takes two and a half
// frames. The flesh leaves it as it entered. It misses the swing's own acceleration over 20 substeps, so the
// tolerance is that of a lag, not of rounding.
TEST(Cut, ATeleportBetweenLinearKeysCarriesTheFleshToo) {
  const BendingBar staying = swinging();
  BendingBar jumping = swinging();
  const Vector3d away(80, 0, 60);
  jumping.character().clips[0].channels.push_back(
      root_channel({{0.0, {0, 0, 0}}, {0.5, {0, 0, 0}}, {0.5 + 1.0 / 24.0, away}, {1.0, away}}));
  const Walked a = run(staying, 60), b = run(jumping, 60);
  for (std::size_t k = 34; k <= 60; ++k)
    ASSERT_LT(furthest(b.positions[k], a.positions[k], away), 1e-2 * bar_height) << "frame " << k;
}

// A small jump is carried if it is marked. The control: unmarked, it is felt as an impulse.
TEST(Cut, AMarkedJumpIsCarriedAndAnUnmarkedOneIsFelt) {
  const BendingBar staying = swinging();
  BendingBar jumping = swinging();
  const Vector3d aside(0, 0, 0.2);
  jumping.character().clips[0].channels.push_back(
      root_channel({{0.0, {0, 0, 0}}, {0.504, aside}}, Interpolation::step));
  jumping.scene.motion.cuts = {0.504};
  const Walked a = run(staying, 40), marked = run(jumping, 40);
  jumping.scene.motion.cuts = {};
  jumping.scene.motion.acceleration_limit = 1e9;
  const Walked felt = run(jumping, 40);
  EXPECT_LT(furthest(marked.positions[32], a.positions[32], aside), 1e-4 * bar_height);
  EXPECT_GT(furthest(felt.positions[32], a.positions[32], aside), 1e-2 * bar_height);
}

// A cut that rotates the body by 90 degrees rotates its flesh and the flesh's velocity.
TEST(Cut, TurnsTheFleshAndItsMotion) {
  BendingBar bar = swinging();
  bar.scene.gravity.setZero();  // gravity does not rotate with the body
  const Walked straight = run(bar, 60);
  const double angle = 0.5 * std::numbers::pi;
  // Angle 0 before the key, `angle` from it on.
  rig::Channel turn = turn_channel(0, {0.0, 0.504}, {0.0, angle});
  turn.interpolation = Interpolation::step;
  bar.character().clips[0].channels.push_back(turn);
  bar.scene.motion.cuts = {0.504};
  const Walked turned = run(bar, 60);
  const Eigen::AngleAxisd R(angle, Vector3d::UnitZ());
  const Vector3d pivot(0, 0.1, 0.1);
  for (std::size_t k = 31; k <= 60; ++k)
    for (std::size_t i = 0; i < bar.model.vertex_count; ++i)
      ASSERT_LT((turned.positions[k][i] - (R * (straight.positions[k][i] - pivot) + pivot)).norm(),
                1e-4 * bar_height)
          << "frame " << k;
}

// The float solver and the Oracle implement cuts separately.
TEST(Cut, TheOracleCarriesAlike) {
  BendingBar bar = swinging();
  bar.character().clips[0].channels.push_back(
      root_channel({{0.0, {0, 0, 0}}, {0.1, {30, 0, 0}}}, Interpolation::step));
  drive::DriveSource drives(bar.scene, bar.model);
  ASSERT_FALSE(drives.drive(6).cuts.empty());
  const auto solver = cpu_reference::make_cpu_solver(bar.model, {}, 2);
  cpu_reference::Oracle oracle(bar.model, {});
  solver->load(drives.initial_state());
  oracle.load(drives.initial_state());
  // As in CpuSolver.StaysNearTheOracle: 12 frames of 8 substeps, 2^-24 x 96 x about 10 roundings.
  const model::Distance distance = model::distance_to(
      bar.model, *solver, oracle, [&](std::uint64_t k) { return drives.drive(k); }, 12);
  EXPECT_LT(distance.largest, 6e-5);
}

// The skeleton is jerked sideways. With an inertia scale of 0 flesh moves along rigidly; with 1 it trails,
// and in between it trails less.
TEST(InertiaScale, IsTheShareOfTheSkeletonsAccelerationThatFleshFeels) {
  BendingBar bar = bending_bar(1.0);
  std::vector<RootKey> keys;
  for (int k = 0; k <= 12; ++k) keys.push_back({k / 24.0, Vector3d(0, 0.1 * k * k / 12.0, 0)});
  bar.character().clips.push_back({"jerk", 0.5, {root_channel(keys)}});
  const auto lag = [&](float carried) {
    bar.model.carried.assign(bar.model.vertex_count, carried);
    if (carried == 0.0f) bar.model.carried.clear();
    const Walked result = run(bar, 24);
    double largest = 0.0;
    for (std::size_t k = 0; k <= 24; ++k)
      largest = std::max(largest, furthest(result.positions[k], result.skinned[k]));
    return largest;
  };
  const double full = lag(0.0f), half = lag(0.5f), none = lag(1.0f);
  EXPECT_GT(full, 5e-3 * bar_height);
  EXPECT_LT(none, 1e-5 * bar_height);
  // Small strains: nearly linear.
  EXPECT_NEAR(half, 0.5 * full, 0.05 * full);
}

TEST(Loop, RepeatsWholeCyclesAndHoldsTheEnd) {
  BendingBar bar = swinging();
  bar.scene.motion.loop = 3;
  bar.scene.motion.hold = 0.5;
  EXPECT_EQ(scene::cycle_frames(bar.scene), 60u);
  EXPECT_EQ(scene::frame_count(bar.scene), 210u);
  const Walked result = run(bar, 210);
  for (std::size_t k = 1; k <= 60; ++k) {
    ASSERT_LT(furthest(result.skinned[60 + k], result.skinned[k]), 1e-9);
    ASSERT_LT(furthest(result.skinned[120 + k], result.skinned[k]), 1e-9);
  }
  for (std::size_t k = 181; k <= 210; ++k) ASSERT_EQ(furthest(result.skinned[k], result.skinned[180]), 0.0);
  // The effect of the start fades: successive cycles differ less and less.
  EXPECT_LT(furthest(result.positions[170], result.positions[110]),
            0.5 * furthest(result.positions[110], result.positions[50]));
}

// A clip of 0.51 s is 30.6 frames: each cycle takes 31, and frames repeat.
TEST(Loop, CyclesAreWholeFrames) {
  BendingBar bar = swinging(0.51);
  bar.scene.motion.loop = 2;
  EXPECT_EQ(scene::frame_count(bar.scene), 62u);
  const Walked result = run(bar, 62);
  EXPECT_LT(furthest(result.skinned[62], result.skinned[31]), 1e-9);
  EXPECT_LT(furthest(result.skinned[31], result.skinned[0]), 1e-6 * bar_height);
}

// A forward walk that loops: at each loop the flesh is carried back to the start.
TEST(Loop, AClipThatDoesNotReturnIsCutAtItsEnd) {
  BendingBar bar = swinging();
  bar.character().clips[0].channels.push_back(root_channel({{0.0, {0, 0, 0}}, {1.0, {1.5, 0, 0}}}));
  bar.scene.motion.loop = 2;
  BendingBar on = swinging();
  on.scene.motion.loop = 2;
  on.scene.motion.cuts = {};
  const Walked back = run(bar, 120), stays = run(on, 120);
  for (std::size_t k = 61; k <= 120; ++k) {
    const double way = 1.5 * static_cast<double>(k - 60) / 60.0;
    ASSERT_LT(furthest(back.positions[k], stays.positions[k], Vector3d(way, 0, 0)), 1e-3 * bar_height)
        << "frame " << k;
  }
}

TEST(Seamless, ALoopEndsAsItBegins) {
  BendingBar bar = swinging();
  const Walked once = run(bar, 60);
  const double jump = furthest(once.positions[60], once.positions[0]);
  bar.scene.motion.seamless = true;
  drive::DriveSource drives(bar.scene, bar.model);
  const auto solver = cpu_reference::make_cpu_solver(bar.model, {}, 2);
  const drive::LeadIn led = drive::lead_in(bar.scene, bar.model, drives, *solver);
  ASSERT_TRUE(led.summary.jump.has_value());
  EXPECT_LE(*led.summary.jump, 1e-3 * bar_height);
  EXPECT_LT(led.summary.cycles, 10u);
  const Walked cycle = run(bar, 60);
  EXPECT_LE(furthest(cycle.positions[60], cycle.positions[0]), 1e-3 * bar_height);
  EXPECT_GT(jump, 1e-3 * bar_height) << "the control: without the preceding cycles, it does not close";
}

}  // namespace

}  // namespace fascicle::tests
