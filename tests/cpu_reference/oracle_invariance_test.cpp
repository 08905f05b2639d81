// Changes that must not affect a trajectory, and the momentum that a free body must conserve.
#include <cmath>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "tests/cpu_reference/mapped_scene.h"
#include "tests/cpu_reference/oracle_run.h"

namespace fascicle::tests::oracle_invariance_test {
namespace {

using cpu_reference::Oracle;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using model::Model;

constexpr double h = 1.0 / 64.0;

// Positions after each of `steps` steps.
std::vector<Points> trajectory(const Scene& scene, int steps, double damping = 0.0) {
  const Model model = model_of(scene, true, damping);
  Points start = rest_points(model);
  for (Vector3d& p : start) p += scene.translation;
  Oracle oracle(model, {});
  set_state(model, oracle, start, scene.velocities);
  TestDrive drive = quiet_drive(model, h, 1, scene.gravity);
  std::vector<Points> all;
  for (int n = 0; n < steps; ++n) {
    advance(oracle, drive);
    all.push_back(oracle.positions());
  }
  return all;
}

void expect_mapped(const std::vector<Points>& a, const std::vector<Points>& b, const Matrix3d& R,
                   const Vector3d& t, double tolerance) {
  double moved = 0.0;
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t n = 0; n < a.size(); ++n) {
    Points image;
    for (const Vector3d& p : a[n]) image.push_back(R * p + t);
    ASSERT_LT(largest_distance(image, b[n]), tolerance) << "step " << n + 1;
    moved = std::max(moved, largest_distance(a[n], a[0]));
  }
  EXPECT_GT(moved, 0.05);  // half a spacing: the body did move
}

// Two runs that differ by rounding (1e-16 m) diverge slowly while no region is near inversion. Stiff springs
// are oscillators, in which kicks add up to about 1e-14 by 200 steps, and about a hundred times that as
// regions rotate far.
constexpr double same_trajectory = 1e-11;

TEST(OracleInvariance, RotatedAndMovedBodyMovesTheSame) {
  const Matrix3d R = exact_rotation();
  const Vector3d t(2, -1, 3);
  for (bool pinned : {false, true}) {
    const Scene scene = make_scene(1, pinned);
    expect_mapped(trajectory(scene, 200), trajectory(mapped(scene, R, t), 200), R, t, same_trajectory);
  }
}

TEST(OracleInvariance, MirroredBodyMovesMirrored) {
  const Matrix3d mirror = Vector3d(1, -1, 1).asDiagonal();
  const Matrix3d both = exact_rotation() * mirror;
  for (bool pinned : {false, true}) {
    const Scene scene = make_scene(2, pinned);
    for (const Matrix3d& Q : {mirror, both})
      expect_mapped(trajectory(scene, 200), trajectory(mapped(scene, Q, Vector3d::Zero()), 200), Q,
                    Vector3d::Zero(), same_trajectory);
  }
}

TEST(OracleInvariance, NumberingDoesNotMatter) {
  const Scene scene = make_scene(3, true);
  const auto new_number = shuffled_numbers(scene.mesh.points.size(), 4);
  const std::vector<Points> a = trajectory(scene, 200);
  const std::vector<Points> b = in_old_numbers(trajectory(renumbered(scene, new_number), 200), new_number);
  expect_mapped(a, b, Matrix3d::Identity(), Vector3d::Zero(), same_trajectory);
}

// A rotated body thrown without spin moves straight at constant speed and keeps its shape.
TEST(OracleInvariance, ThrownRigidBodyGoesStraight) {
  Scene scene = make_scene(5, false);
  const Vector3d v(1.5, -0.25, 5.0);
  const Model model = model_of(scene);
  const Matrix3d R = exact_rotation();
  Points start;
  for (const Vector3d& p : rest_points(model)) start.push_back(R * p);
  Oracle oracle(model, {});
  set_state(model, oracle, start, Points(start.size(), v));
  TestDrive drive = quiet_drive(model, h);
  for (int n = 1; n <= 100; ++n) {
    advance(oracle, drive);
    Points expected;
    for (const Vector3d& p : start) expected.push_back(p + n * h * v);
    // Coordinates of up to 8 m are rounded by 9e-16. If all errors had the same sign, they would grow like
    // n^2/2.
    ASSERT_LT(largest_distance(oracle.positions(), expected), 5e-12) << "step " << n;
  }
}

struct Momentum {
  Vector3d linear = Vector3d::Zero();
  Vector3d angular = Vector3d::Zero();
  double linear_scale = 0.0;   // sum m |v|
  double angular_scale = 0.0;  // sum m |q| |v|
};

Momentum momentum_of(const Model& model, const Oracle& oracle) {
  Momentum m;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    const Vector3d& q = oracle.positions()[i];
    const Vector3d& v = oracle.velocities()[i];
    m.linear += model.mass[i] * v;
    m.angular += model.mass[i] * q.cross(v);
    m.linear_scale += model.mass[i] * v.norm();
    m.angular_scale += model.mass[i] * q.norm() * v.norm();
  }
  return m;
}

struct Drift {
  double linear = 0.0;
  double angular = 0.0;
};

// The largest relative change of the momenta of a free, tumbling and wobbling body over 1,000 steps. Muscles
// are on, so T takes part; so can the volume term.
Drift momentum_drift(unsigned seed, bool momentum_scaled, float volume_gain = 0.0f) {
  const Scene scene = make_scene(seed, false);
  Model model = model_of(scene, momentum_scaled);
  if (volume_gain > 0.0f) add_volume(model, volume_gain);
  add_muscle(model, {0.6, 0.0, 0.8}, 0.5, 0.25, 2);
  Oracle oracle(model, {});
  // Around its centre and without drift: the farther from the origin, the coarser are double positions, and
  // 1/h times that limits the accuracy of velocities.
  Vector3d centre = Vector3d::Zero();
  Vector3d velocity = Vector3d::Zero();
  double mass = 0.0;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    centre += model.mass[i] * rest_points(model)[i];
    velocity += model.mass[i] * scene.velocities[i];
    mass += model.mass[i];
  }
  Points start = rest_points(model);
  Points velocities = scene.velocities;
  for (Vector3d& p : start) p -= centre / mass;
  for (Vector3d& v : velocities) v -= velocity / mass;
  set_state(model, oracle, start, velocities);
  TestDrive drive = quiet_drive(model, h);
  drive.muscles.assign(1, shader::Muscle{0.75f, 0, 0, 0.125f, 0.5f});
  const Momentum before = momentum_of(model, oracle);
  Drift drift;
  double linear_scale = before.linear_scale;
  double angular_scale = before.angular_scale;
  for (int n = 0; n < 1000; ++n) {
    advance(oracle, drive);
    const Momentum now = momentum_of(model, oracle);
    linear_scale = std::max(linear_scale, now.linear_scale);
    angular_scale = std::max(angular_scale, now.angular_scale);
    drift.linear = std::max(drift.linear, (now.linear - before.linear).norm());
    drift.angular = std::max(drift.angular, (now.angular - before.angular).norm());
  }
  return {drift.linear / linear_scale, drift.angular / angular_scale};
}

TEST(OracleMomentum, FreeBodyKeepsBothMomenta) {
  for (unsigned seed : {11u, 12u, 13u, 14u}) {
    const Drift drift = momentum_drift(seed, true, seed > 12 ? 3.0f : 0.0f);
    // A goal 0.2 m from the origin is rounded by 3e-17, its pull on the velocity by 1/h = 64 times that:
    // 2e-15 m/s, or 2e-14 of the velocities here, for each of 36 vertices in each of 1,000 steps. Random
    // errors, relative to the sum over all vertices, add up to 2e-14 sqrt(1000/36) = 1e-13. The margin of ten
    // is for errors that are not random.
    EXPECT_LT(drift.linear, 1e-12) << "seed " << seed;
    EXPECT_LT(drift.angular, 2e-12) << "seed " << seed;
  }
}

// The control: with the weights as printed, a free body pushes itself.
TEST(OracleMomentum, PrintedWeightsDoNot) {
  for (unsigned seed : {11u, 12u, 13u}) {
    const Drift drift = momentum_drift(seed, false);
    EXPECT_GT(drift.linear, 1e-3) << "seed " << seed;
    EXPECT_GT(drift.angular, 1e-3) << "seed " << seed;
  }
}

// A skeleton that bends while moving at 5 m/s, in whole and half metres a frame. Positions are relative to an
// origin that follows in whole metres. As damping is relative to the skeleton, only the translation may
// change.
TEST(OracleInvariance, CarriedFrameChangesNothing) {
  constexpr std::uint32_t substeps = 4;
  constexpr int frames = 64;
  const Scene scene = make_scene(21, true);
  Model model = model_of(scene, true, 6.0);
  add_skeleton(model);

  const auto run = [&](double speed, double push, std::vector<Points>& all, double* lag) {
    Oracle oracle(model, {});
    set_state(model, oracle, rest_points(model), Points(model.vertex_count, Vector3d(push, 0, 0)));
    double origin = 0.0;
    for (int f = 0; f < frames; ++f) {
      TestDrive drive = quiet_drive(model, h, substeps, Vector3d(0, -6.25, 0));
      const double end = speed * h * substeps * (f + 1);
      const double new_origin = std::floor(end);
      drive.drive.origin = {new_origin, 0, 0};
      drive.drive.origin_shift = {float(new_origin - origin), 0, 0};
      origin = new_origin;
      for (std::uint32_t s = 0; s < substeps; ++s) {
        const double time = h * (double(substeps) * f + s + 1);
        shader::Bone& moving = drive.bones[2 * s + 1];
        const float bend = float(0.25 * std::sin(6.0 * time));
        moving.xy = -bend;  // a shear and a stretch; skinning takes any affine map
        moving.yx = bend;
        for (std::uint32_t j = 0; j < 2; ++j) drive.bones[2 * s + j].xt = float(speed * time - origin);
      }
      advance(oracle, drive);
      Points world = oracle.positions();
      for (std::uint32_t i = 0; i < model.vertex_count; ++i) world[i].x() += origin - end;
      all.push_back(world);
    }
    if (lag) *lag = largest_distance(all.back(), all.front());
  };

  std::vector<Points> standing, carried, pushed;
  double lag = 0.0;
  run(0.0, 0.0, standing, &lag);
  run(5.0, 5.0, carried, nullptr);
  run(5.0, 0.0, pushed, nullptr);
  EXPECT_GT(lag, 0.01);  // the body did move
  double worst = 0.0;
  double control = 0.0;
  for (int f = 0; f < frames; ++f) {
    worst = std::max(worst, largest_distance(standing[std::size_t(f)], carried[std::size_t(f)]));
    control = std::max(control, largest_distance(standing[std::size_t(f)], pushed[std::size_t(f)]));
  }
  // All translations and origins are exact in float (5/64 m a substep), so only double rounding remains:
  // 1e-16 of a metre, over h for the skinned velocity, over 256 steps.
  EXPECT_LT(worst, 1e-12);
  EXPECT_GT(control, 0.05);  // starting without the 5 m/s is detected
}

}  // namespace
}  // namespace fascicle::tests::oracle_invariance_test
