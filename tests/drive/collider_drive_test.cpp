// The positions of solids in each substep: between keys, attached to a joint, at a cut, and at the start of
// another cycle.
#include "host/drive/collider_drive.h"

#include <cmath>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "host/build/build.h"
#include "host/drive/drive_source.h"
#include "host/scene/scene.h"

namespace fascicle::tests {
namespace {

using drive::ColliderDrive;
using scene::Collider;
using scene::ColliderShape;
using scene::Vector3d;

// A point of the body's space in the solid's local space, both in metres.
Vector3d seen_from(const float* rows, const Vector3d& point, double unit, const Vector3d& origin) {
  const Vector3d x = (point - origin) / unit;
  Vector3d seen;
  for (int r = 0; r < 3; ++r, rows += 4)
    seen[r] = double(rows[0]) * x[0] + double(rows[1]) * x[1] + double(rows[2]) * x[2] + double(rows[3]);
  return unit * seen;
}

scene::Scene scene_with(Collider collider) {
  scene::Scene scene;
  scene.colliders = {std::move(collider)};
  return scene;
}

Collider keyed_box() {
  Collider box;
  box.shape = ColliderShape::box;
  box.center = {1.0, 0.0, 0.0};
  box.size = {0.5, 0.25, 0.125};
  box.times = {1.0, 2.0};
  box.offsets = {{0.0, 0.0, 0.0}, {0.0, 2.0, 0.0}};
  box.turns = {{0.0, 0.0, 0.0}, {0.0, 0.0, 90.0}};
  return box;
}

// By hand: halfway between its keys it has moved half the way and turned by half the angle.
TEST(ColliderDrive, GoesAlongItsKeys) {
  const scene::Scene scene = scene_with(keyed_box());
  const ColliderDrive drive(scene, model::Model{}, 0.01);
  const double half = std::sqrt(0.5);
  struct Case {
    double time, height, cosine, sine;
  };
  for (const Case& c : {Case{0.0, 0.0, 1.0, 0.0},
                        {1.0, 0.0, 1.0, 0.0},
                        {1.5, 1.0, half, half},
                        {2.0, 2.0, 0.0, 1.0},
                        {9.0, 2.0, 0.0, 1.0}}) {
    const scene::Solid solid = drive.solids({c.time})[0];
    EXPECT_LT((solid.center - Vector3d(1.0, c.height, 0.0)).norm(), 1e-12) << c.time;
    EXPECT_LT((solid.axes.col(0) - Vector3d(c.cosine, c.sine, 0.0)).norm(), 1e-12) << c.time;
    EXPECT_LT((solid.half_size - Vector3d(0.25, 0.125, 0.0625)).norm(), 1e-12);
  }
}

// The maps take the solid's position to its local origin, at the end and at the start of the substep, for any
// unit and origin.
TEST(ColliderDrive, HasTheWayThroughASubstep) {
  const scene::Scene scene = scene_with(keyed_box());
  model::Model model;
  model.unit = 0.5;
  const ColliderDrive drive(scene, model, 0.01);
  std::vector<shader::Collider> made;
  const Vector3d origin(3.0, -1.0, 0.5);
  drive.append({1.25}, {1.5}, origin, made);
  ASSERT_EQ(made.size(), 1u);
  // Float rounding at a few working units.
  constexpr double rounding = 1e-6;
  EXPECT_LT(seen_from(&made[0].xx, {1.0, 1.0, 0.0}, 0.5, origin).norm(), rounding);
  EXPECT_LT(seen_from(&made[0].before_xx, {1.0, 0.5, 0.0}, 0.5, origin).norm(), rounding);
  EXPECT_GT(seen_from(&made[0].before_xx, {1.0, 1.0, 0.0}, 0.5, origin).norm(), 0.4);
  EXPECT_EQ(made[0].half_x, 0.5f);
  // The lift rate is 5 per second; 0.01 s gives an exponent of 0.05.
  EXPECT_NEAR(double(made[0].lifted), 1.0 - std::exp(-0.05), 1e-7);
}

Collider ball() {
  Collider ball;
  ball.shape = ColliderShape::sphere;
  ball.radius = 0.02;
  ball.center = {0.5, 0.0, 0.0};
  return ball;
}
Collider ball_on_forearm() {
  Collider bound = ball();
  bound.joint = "forearm";
  return bound;
}

struct MadeArm {
  explicit MadeArm(const Collider& collider, const std::vector<std::string>& set = {})
      : scene(scene::load_scene("arm", {.set = set})) {
    scene.colliders = {collider};
    build::Report report;
    model = build::build_model(scene, report);
  }
  Vector3d origin_of(const model::Drive& drive) const {
    return {drive.origin[0], drive.origin[1], drive.origin[2]};
  }
  scene::Scene scene;
  model::Model model;
};

// The forearm rotates about the elbow at (0.3, 0, 0), so an attached solid keeps its distance from it. Each
// substep starts where the previous one ended.
TEST(ColliderDrive, GoesWithItsJoint) {
  const MadeArm arm(ball_on_forearm());
  drive::DriveSource drives(arm.scene, arm.model);
  const Vector3d elbow(0.3, 0.0, 0.0);
  double furthest = 0.0;
  for (std::uint64_t frame = 0; frame <= 130; frame += 13) {
    const scene::Solid ball = drives.solids(frame)[0];
    EXPECT_NEAR((ball.center - elbow).norm(), 0.2, 1e-9) << frame;
    furthest = std::max(furthest, (ball.center - Vector3d(0.5, 0.0, 0.0)).norm());
    if (frame == 0) continue;
    const model::Drive drive = drives.drive(frame);
    const Vector3d origin = arm.origin_of(drive);
    const shader::Collider& last = drive.colliders.back();
    EXPECT_LT(seen_from(&last.xx, ball.center, arm.model.unit, origin).norm(), 1e-6);
    for (std::size_t s = 1; s < drive.colliders.size(); ++s)
      for (int k = 0; k < 12; ++k)
        EXPECT_EQ((&drive.colliders[s].before_xx)[k], (&drive.colliders[s - 1].xx)[k]) << frame;
  }
  EXPECT_GT(furthest, 0.3);  // the arm bends
}

// At a cut the solid is at its new position for the whole substep, so it does not sweep flesh along.
TEST(ColliderDrive, StandsAtACut) {
  const MadeArm arm(ball_on_forearm(), {"motion.cuts=[1.0]"});
  drive::DriveSource drives(arm.scene, arm.model);
  const auto frame = static_cast<std::uint64_t>(std::lround(arm.scene.fps));
  std::size_t standing = 0;
  for (std::uint64_t k = frame - 1; k <= frame + 1; ++k) {
    const model::Drive drive = drives.drive(k);
    ASSERT_EQ(drive.colliders.size(), drive.substeps);
    for (const shader::Collider& c : drive.colliders) {
      bool stands = true;
      for (int e = 0; e < 12; ++e) stands = stands && (&c.xx)[e] == (&c.before_xx)[e];
      standing += stands ? 1U : 0U;
    }
  }
  EXPECT_EQ(standing, 1u);
}

// A keyed solid repeats with the clip and restarts with it.
TEST(ColliderDrive, RepeatsWithTheClip) {
  Collider keyed = ball();
  keyed.times = {0.0, 4.0};
  keyed.offsets = {{0.0, 0.0, 0.0}, {0.0, 0.0, 1.0}};
  const MadeArm arm(keyed, {"motion.loop=2"});
  drive::DriveSource drives(arm.scene, arm.model);
  const std::uint64_t cycle = scene::cycle_frames(arm.scene);
  for (const std::uint64_t k : {1, 7, 100})
    EXPECT_LT((drives.solids(k)[0].center - drives.solids(k + cycle)[0].center).norm(), 1e-9) << k;
  const model::Drive begins = drives.drive(cycle + 1);
  const Vector3d start(0.5, 0.0, 0.0);
  EXPECT_LT(seen_from(&begins.colliders[0].before_xx, start, arm.model.unit, arm.origin_of(begins)).norm(),
            1e-6);
}

// Flesh in or near a solid that is attached to a joint is spared; flesh further away is not. A free solid
// spares nothing.
TEST(ColliderDrive, SparesTheFleshAroundItsJoint) {
  const MadeArm bound(ball_on_forearm());
  std::size_t spared = 0;
  for (std::uint32_t i = 0; i < bound.model.vertex_count; ++i) {
    const float* rest = bound.model.rest.data() + 3 * std::size_t{i};
    const Vector3d place =
        Vector3d(bound.model.rest_origin[0], bound.model.rest_origin[1], bound.model.rest_origin[2]) +
        bound.model.unit * Vector3d(double{rest[0]}, double{rest[1]}, double{rest[2]});
    const double distance = (place - Vector3d(0.5, 0.0, 0.0)).norm();
    EXPECT_EQ(bound.model.spared[i], distance <= 0.022 ? 1u : 0u) << distance;
    spared += bound.model.spared[i];
  }
  EXPECT_GT(spared, 5u);
  const MadeArm free(ball());
  for (const std::uint32_t bits : free.model.spared) ASSERT_EQ(bits, 0u);
}

}  // namespace
}  // namespace fascicle::tests
