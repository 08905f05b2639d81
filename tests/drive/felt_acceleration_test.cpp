// The acceleration that flesh feels from sampled keys and from keys that jump is the same at every frame
// rate.
#include "host/drive/felt_acceleration.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "cpu_reference/oracle/oracle.h"
#include "cpu_reference/solver/cpu_solver.h"
#include "host/drive/drive_source.h"
#include "host/drive/timeline.h"
#include "host/model/validate.h"
#include "host/rig/smooth_clip.h"
#include "tests/drive/bending_bar.h"
#include "tests/support/test_models.h"

namespace fascicle::tests {
namespace {

using Eigen::Vector3d;

// The bar thrown up and down for a second, with 24 keys per second.
BendingBar thrown_bar(scene::KeyInterpolation interpolation, double fps) {
  BendingBar bar = bending_bar(1.0);
  std::vector<RootKey> keys;
  for (int k = 0; k <= 24; ++k)
    keys.push_back({k / 24.0, Vector3d(0, 0.12 * std::sin(2.0 * std::numbers::pi * 2.0 * k / 24.0), 0)});
  rig::Clip clip{"throw", 1.0, {root_channel(keys)}};
  if (interpolation == scene::KeyInterpolation::smooth) clip = rig::smooth_clip(clip, false, 0.0, 1.0);
  bar.character().clips.push_back(clip);
  bar.scene.fps = fps;
  bar.scene.solver.substeps = 4;
  return bar;
}

double largest_acceleration(BendingBar bar) {
  const double extents[] = {bar_height};
  drive::Timeline timeline(bar.scene, bar.character(), extents, bar.scene.solver.substeps);
  const double h = 1.0 / (bar.scene.fps * bar.scene.solver.substeps);
  double largest = 0.0;
  for (std::uint64_t count = 2; count <= scene::cycle_frames(bar.scene) * bar.scene.solver.substeps;
       ++count) {
    const Vector3d a = timeline.root(timeline.pose(count - 2)), b = timeline.root(timeline.pose(count - 1)),
                   c = timeline.root(timeline.pose(count));
    largest = std::max(largest, ((c - b) - (b - a)).norm() / (h * h));
  }
  return largest;
}

// The largest lag of all frames in m, as root mean square over the vertices.
double peak_lag(BendingBar bar, double youngs_modulus) {
  bar.model = make_implicit(bar.model, youngs_modulus);
  const Walked result = run(bar, scene::cycle_frames(bar.scene));
  double peak = 0.0;
  for (std::size_t k = 0; k < result.positions.size(); ++k) {
    double sum = 0.0;
    for (std::size_t i = 0; i < result.positions[k].size(); ++i)
      sum += (result.positions[k][i] - result.skinned[k][i]).squaredNorm();
    peak = std::max(peak, std::sqrt(sum / static_cast<double>(result.positions[k].size())));
  }
  return peak;
}

// Linear keys are impulses, which get harder with shorter steps; the true motion has (4 pi)^2 0.12 = 19
// m/s^2.
TEST(FrameRate, SampledKeysAccelerateAlikeAtEveryRate) {
  const double wanted = std::pow(4.0 * std::numbers::pi, 2) * 0.12;
  double slowest = 0.0;
  for (const double fps : {24.0, 60.0, 120.0}) {
    // Inside, the curve matches the acceleration of the wave within (omega h)^2/12 = 2 %. At its ends the
    // slopes are one-sided, with an error of up to (omega h)^2/3 of the velocity over a key: 15 % of the
    // acceleration.
    EXPECT_NEAR(largest_acceleration(thrown_bar(scene::KeyInterpolation::smooth, fps)), wanted, 0.2 * wanted);
    const double lines = largest_acceleration(thrown_bar(scene::KeyInterpolation::as_authored, fps));
    if (fps == 24.0) slowest = lines;
    if (fps == 120.0) {
      EXPECT_GT(lines, 4.5 * slowest);
    }
  }
}

// Within a tenth: 14.8 to 15.1 mm here. The control: linear keys give 14.7 mm at 24 fps and 17.1 mm at 120
// fps.
TEST(FrameRate, FleshLagsAlikeAtEveryRate) {
  const auto lag = [](scene::KeyInterpolation interpolation, double fps) {
    return peak_lag(thrown_bar(interpolation, fps), 3e4);
  };
  const double smooth = lag(scene::KeyInterpolation::smooth, 60.0);
  EXPECT_GT(smooth, 2e-3 * bar_height);
  for (const double fps : {24.0, 30.0, 120.0})
    EXPECT_NEAR(lag(scene::KeyInterpolation::smooth, fps), smooth, 0.1 * smooth) << fps;
  EXPECT_GT(lag(scene::KeyInterpolation::as_authored, 120.0),
            1.1 * lag(scene::KeyInterpolation::as_authored, 24.0));
}

// Accelerated along y at 9.6 m/s^2.
BendingBar accelerated_bar() {
  BendingBar bar = bending_bar(0.5);
  std::vector<RootKey> keys;
  for (int k = 0; k <= 12; ++k) keys.push_back({k / 24.0, Vector3d(0, 0.1 * k * k / 12.0, 0)});
  bar.character().clips.push_back(rig::smooth_clip({"throw", 0.5, {root_channel(keys)}}, false, 0.0, 0.5));
  return bar;
}

double largest_lag(const BendingBar& bar) {
  const Walked result = run(bar, scene::cycle_frames(bar.scene));
  double largest = 0.0;
  for (std::size_t k = 0; k < result.positions.size(); ++k)
    largest = std::max(largest, furthest(result.positions[k], result.skinned[k]));
  return largest;
}

TEST(AccelerationLimit, FleshFeelsNoMoreThanTheLimit) {
  BendingBar bar = accelerated_bar();
  const double full = largest_lag(bar);
  EXPECT_GT(full, 5e-3 * bar_height);
  bar.scene.motion.acceleration_limit = 4.8;
  // Strains are small, so the response is nearly linear.
  EXPECT_NEAR(largest_lag(bar), 0.5 * full, 0.05 * full);
  bar.scene.motion.acceleration_limit = 1e-6;
  EXPECT_LT(largest_lag(bar), 1e-5 * bar_height);
  // A limit above the largest acceleration changes no bit.
  const Walked free = run(accelerated_bar(), 30);
  bar.scene.motion.acceleration_limit = 9.7;
  EXPECT_EQ(run(bar, 30).last, free.last);
}

// The root goes up and down at a constant speed. At each turn its velocity changes at once, so its
// acceleration is as large as the substep is short. Flesh feels the same at every length of it: up to the
// limit, for `felt_window`.
TEST(AccelerationLimit, IsTheSameForAllSubsteps) {
  const auto zigzag = [](std::uint32_t substeps) {
    BendingBar bar = bending_bar(1.0);
    bar.scene.motion.interpolation = scene::KeyInterpolation::smooth;  // for the default limit
    bar.scene.solver.substeps = substeps;
    std::vector<RootKey> keys;
    for (int k = 0; k <= 5; ++k) keys.push_back({0.2 * k, Vector3d(0, k % 2 == 0 ? 0.0 : 0.12, 0)});
    bar.character().clips.push_back({"zigzag", 1.0, {root_channel(keys)}});
    return bar;
  };
  const BendingBar coarse = zigzag(4);
  const double expected = drive::DriveSource(coarse.scene, coarse.model).thrown().at(0).acceleration;
  EXPECT_NEAR(expected, 2.0 * 0.6 / drive::felt_window, 1.0);
  const double lag = peak_lag(coarse, 3e4);
  for (const std::uint32_t substeps : {8u, 16u, 32u}) {
    const BendingBar fine = zigzag(substeps);
    EXPECT_NEAR(drive::DriveSource(fine.scene, fine.model).thrown().at(0).acceleration, expected,
                1e-6 * expected)
        << substeps;
    // Implicit steps damp by their length: 17 % between 1/480 and 1/2400 s.
    EXPECT_NEAR(peak_lag(fine, 3e4), lag, 0.25 * lag) << substeps;
  }
}

// A pose that flips within a substep is carried there and held there: its flesh must not keep the velocity of
// the flip. The control: without a limit it is thrown the further the shorter the substep.
TEST(AccelerationLimit, AFlipThrowsNoFlesh) {
  const auto flip = [](std::uint32_t substeps, double seconds) {
    BendingBar bar = bending_bar(0.5);
    bar.scene.motion.interpolation = scene::KeyInterpolation::smooth;  // for the default limit
    bar.scene.solver.substeps = substeps;
    rig::Channel turn = turn_channel(1, {0.0, 0.25, 0.25 + seconds, 0.5}, {0.0, 0.0, 0.7, 0.7});
    if (seconds == 0.0) {
      turn = turn_channel(1, {0.0, 0.25}, {0.0, 0.7});
      turn.interpolation = rig::Interpolation::step;
    }
    bar.character().clips.push_back({"flip", 0.5, {turn}});
    return bar;
  };
  const double lag = peak_lag(flip(4, 0.0), 3e4);
  for (const double seconds : {0.0, 0.001, 0.002})
    for (const std::uint32_t substeps : {4u, 8u, 24u}) {
      BendingBar bar = flip(substeps, seconds);
      EXPECT_LT(peak_lag(bar, 3e4), 1.5 * lag + 1e-3 * bar_height) << seconds << " " << substeps;
      bar.scene.motion.acceleration_limit = 1e9;
      if (substeps == 24 && seconds == 0.0) {
        EXPECT_GT(peak_lag(bar, 3e4), 3.0 * lag);
      }
    }
}

// A forearm that jumps to another angle between two keys.
BendingBar leaping_bar() {
  BendingBar bar = bending_bar(1.0);
  bar.scene.motion.interpolation = scene::KeyInterpolation::smooth;
  std::vector<double> times, angles;
  for (int k = 0; k <= 24; ++k) {
    times.push_back(k / 24.0);
    angles.push_back(k < 12 ? 0.0 : 2.0);
  }
  bar.character().clips.push_back(
      rig::smooth_clip({"leap", 1.0, {turn_channel(1, times, angles)}}, false, 0.0, 1.0));
  return bar;
}

TEST(AccelerationLimit, IsSaidWhereItBites) {
  BendingBar bar = leaping_bar();
  {
    drive::DriveSource drives(bar.scene, bar.model);
    // Rest positions are floats.
    EXPECT_NEAR(drives.acceleration_limit(0), drive::default_acceleration_limit * bar_height, 1e-4);
    const auto thrown = drives.thrown();
    ASSERT_EQ(thrown.size(), 1u);
    EXPECT_EQ(thrown[0].joint, 1u);
    EXPECT_GT(thrown[0].time, 11.0 / 24.0 - 1e-9);
    EXPECT_LT(thrown[0].time, 12.0 / 24.0 + 1e-9);
    // The frame that shows this time, or the next one if it lies between two.
    EXPECT_EQ(static_cast<double>(thrown[0].frame), std::ceil(thrown[0].time * 60.0 - 1e-9));
    // A smooth step turns by 2 rad in 1/24 s: at its ends 6 x 2 x 24^2 rad/s^2, at 0.3 m and more.
    EXPECT_GT(thrown[0].acceleration, 12.0 * 24.0 * 24.0 * 0.3 * 0.7);
    EXPECT_LT(thrown[0].acceleration, 12.0 * 24.0 * 24.0 * 0.35 * 1.1);
  }
  const double bounded = largest_lag(bar);
  bar.scene.motion.acceleration_limit = 1e9;
  EXPECT_TRUE(drive::DriveSource(bar.scene, bar.model).thrown().empty());
  EXPECT_LT(bounded, 0.8 * largest_lag(bar));
  // Intended motion is far below the limit: a swing at 2 Hz.
  BendingBar meant = thrown_bar(scene::KeyInterpolation::smooth, 60.0);
  meant.scene.motion.interpolation = scene::KeyInterpolation::smooth;
  EXPECT_TRUE(drive::DriveSource(meant.scene, meant.model).thrown().empty());
}

// A clip need not end at a whole frame. Its skeleton then stops within the last frame, and nobody has to look
// for keys there. The control: a pose that is held after the clip does stop the skeleton.
TEST(AccelerationLimit, IsNotSaidOfAClipsEnd) {
  BendingBar bar = bending_bar(0.495);
  bar.scene.motion.interpolation = scene::KeyInterpolation::smooth;
  const double seconds = bar.scene.end, speed = 1.2;
  bar.character().clips.push_back(
      {"ride",
       seconds,
       {root_channel({{0.0, Vector3d::Zero()}, {seconds, Vector3d(speed * seconds, 0, 0)}})}});
  ASSERT_GT(static_cast<double>(scene::cycle_frames(bar.scene)), seconds * bar.scene.fps);
  EXPECT_TRUE(drive::DriveSource(bar.scene, bar.model).thrown().empty());
  bar.scene.motion.hold = 0.5;
  const auto thrown = drive::DriveSource(bar.scene, bar.model).thrown();
  ASSERT_FALSE(thrown.empty());
  EXPECT_NEAR(thrown[0].time, seconds, 1.0 / bar.scene.fps);
}

// Both look at every substep of the clip: whoever waits may stop them in any frame.
TEST(AccelerationLimit, LookingForThrowsCanBeStopped) {
  BendingBar bar = leaping_bar();
  drive::DriveSource drives(bar.scene, bar.model);
  std::uint64_t frames = 0, substeps = 0;
  const auto visit = [&](const std::vector<drive::DriveSource::Throw>&) { ++substeps; };
  (void)drives.thrown([&] { return ++frames != 0; });
  EXPECT_GT(frames, 20u);
  frames = 0;
  drives.for_each_throw(visit, [&] { return ++frames < 3; });
  EXPECT_EQ(frames, 3u);
  EXPECT_EQ(substeps, 3 * drives.substeps() - 1);
  EXPECT_FALSE(drives.thrown().empty());
  EXPECT_TRUE(drives.thrown([] { return false; }).empty());
}

// The limit is applied as a cut, which the float solver and the Oracle implement separately.
TEST(AccelerationLimit, TheOracleFeelsTheSame) {
  BendingBar bar = accelerated_bar();
  bar.scene.motion.acceleration_limit = 4.8;
  drive::DriveSource drives(bar.scene, bar.model);
  ASSERT_EQ(drives.drive(3).cuts.size(), 8u);
  const auto solver = cpu_reference::make_cpu_solver(bar.model, {}, 2);
  cpu_reference::Oracle oracle(bar.model, {});
  solver->load(drives.initial_state());
  oracle.load(drives.initial_state());
  // As in Cut.TheOracleCarriesAlike.
  const model::Distance distance = model::distance_to(
      bar.model, *solver, oracle, [&](std::uint64_t k) { return drives.drive(k); }, 12);
  EXPECT_LT(distance.largest, 6e-5);
}

}  // namespace
}  // namespace fascicle::tests
