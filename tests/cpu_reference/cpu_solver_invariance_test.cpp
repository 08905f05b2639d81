// Changes that must not affect a trajectory, in float: the bodies of the Oracle's invariance tests, on
// CpuSolver.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "cpu_reference/solver/cpu_solver.h"
#include "tests/cpu_reference/mapped_scene.h"

namespace fascicle::tests {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using model::Model;

constexpr double h = 1.0 / 64.0;
constexpr int steps = 100;

// Positions after each step. Damping of 2 1/s lets rounding errors fade within a second.
std::vector<Points> trajectory(const Scene& scene) {
  const Model model = model_of(scene, true, 2.0);
  const auto solver = cpu_reference::make_cpu_solver(model, {}, 1);
  model::State state = solver->save();
  Points start = rest_points(model);
  for (Vector3d& p : start) p += scene.translation;
  state.positions = to_floats(start);
  state.velocities = to_floats(scene.velocities);
  solver->load(state);
  TestDrive drive = quiet_drive(model, h, 1, scene.gravity);
  std::vector<Points> all;
  for (int n = 0; n < steps; ++n) {
    solver->submit(drive.get(), {.positions = true});
    const model::Frame frame = solver->collect();
    Points& points = all.emplace_back();
    for (std::size_t i = 0; i < model.vertex_count; ++i)
      points.emplace_back(double{frame.positions[3 * i]}, double{frame.positions[3 * i + 1]},
                          double{frame.positions[3 * i + 2]});
  }
  return all;
}

// The largest distance of b from the image of a, over all steps and vertices.
double distance_from_image(const std::vector<Points>& a, const std::vector<Points>& b, const Matrix3d& R,
                           const Vector3d& t) {
  double largest = 0.0;
  for (std::size_t n = 0; n < a.size(); ++n) {
    Points image;
    for (const Vector3d& p : a[n]) image.push_back(R * p + t);
    largest = std::max(largest, largest_distance(image, b[n]));
  }
  return largest;
}

double largest_motion(const std::vector<Points>& trajectory) {
  double largest = 0.0;
  for (const Points& points : trajectory)
    largest = std::max(largest, largest_distance(points, trajectory[0]));
  return largest;
}

// The effect of rounding alone. A step rounds positions to half an ULP of their coordinates, d = 2^-26 m for
// this body (0.25 m to 0.5 m), and h v carries the error on. In a free body, kicks of d per step with random
// signs add up to d sqrt(1 + 4 + 9 + ... + steps^2). `magnitude` is the largest coordinate, in units of half
// a metre.
double rounding_apart(double magnitude) {
  return 0x1p-26 * magnitude * std::sqrt(double{steps} * steps * steps / 3.0);
}

constexpr unsigned first_seed = 1, last_seed = 5;

// Runs `compare` on free and pinned bodies, and checks that they moved by more than a tenth of their spacing
// (0.1 m).
template <class Compare>
void for_each_body(const Compare& compare) {
  for (unsigned seed = first_seed; seed <= last_seed; ++seed)
    for (const bool pinned : {false, true}) {
      SCOPED_TRACE("seed " + std::to_string(seed) + (pinned ? ", pinned" : ", free"));
      const Scene scene = make_scene(seed, pinned);
      const std::vector<Points> a = trajectory(scene);
      EXPECT_GT(largest_motion(a), 0.01);
      compare(scene, a);
    }
}

// Measured: at most 3.2e-6 of 8.6e-6.
TEST(CpuSolverInvariance, RotatedBodyMovesTheSame) {
  const Matrix3d R = exact_rotation();
  for_each_body([&](const Scene& scene, const std::vector<Points>& a) {
    const std::vector<Points> b = trajectory(mapped(scene, R, Vector3d::Zero()));
    EXPECT_LT(distance_from_image(a, b, R, Vector3d::Zero()), rounding_apart(1.0));
    // The control: the motion is rotated, not the same.
    EXPECT_GT(distance_from_image(a, b, Matrix3d::Identity(), Vector3d::Zero()), 0.01);
  });
}

// Coordinates up to 4 m instead of half a metre are rounded eight times as coarsely. Measured: at most 3.3e-5
// of 6.9e-5.
TEST(CpuSolverInvariance, RotatedAndMovedBodyMovesTheSame) {
  const Matrix3d R = exact_rotation();
  const Vector3d t(2, -1, 3);
  for_each_body([&](const Scene& scene, const std::vector<Points>& a) {
    EXPECT_LT(distance_from_image(a, trajectory(mapped(scene, R, t)), R, t), rounding_apart(8.0));
  });
}

// Exact: rounding to nearest treats x and -x alike, and no kernel distinguishes sides.
TEST(CpuSolverInvariance, MirroredBodyMovesMirroredToTheBit) {
  for (const Vector3d& signs : {Vector3d(-1, 1, 1), Vector3d(1, -1, 1), Vector3d(1, 1, -1)}) {
    const Matrix3d mirror = signs.asDiagonal();
    for_each_body([&](const Scene& scene, const std::vector<Points>& a) {
      const std::vector<Points> b = trajectory(mapped(scene, mirror, Vector3d::Zero()));
      EXPECT_EQ(distance_from_image(a, b, mirror, Vector3d::Zero()), 0.0);
      EXPECT_GT(distance_from_image(a, b, Matrix3d::Identity(), Vector3d::Zero()), 0.01);
    });
  }
}

// Sums run in another order, so bits differ (the numbering is part of a Model) by no more than rounding.
// Measured: at most 2.1e-6 of 8.6e-6.
TEST(CpuSolverInvariance, NumberingMattersByRoundingOnly) {
  double largest = 0.0;
  for_each_body([&](const Scene& scene, const std::vector<Points>& a) {
    const auto new_number = shuffled_numbers(scene.mesh.points.size(), 4);
    const std::vector<Points> b = trajectory(renumbered(scene, new_number));
    const double apart =
        distance_from_image(a, in_old_numbers(b, new_number), Matrix3d::Identity(), Vector3d::Zero());
    EXPECT_LT(apart, rounding_apart(1.0));
    largest = std::max(largest, apart);
    EXPECT_GT(distance_from_image(a, b, Matrix3d::Identity(), Vector3d::Zero()), 0.01);
  });
  EXPECT_GT(largest, 0.0) << "nothing was renumbered";
}

}  // namespace
}  // namespace fascicle::tests
