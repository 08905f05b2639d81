// The equations one by one: (9), (8)(10)(11) on rigid motions, (15)(16)(17).
#include "cpu_reference/oracle/oracle_equations.h"

#include <cmath>
#include <numbers>
#include <random>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "tests/cpu_reference/oracle_run.h"

namespace fascicle::tests {
namespace {

using cpu_reference::best_rotation;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double normal() { return normal_(engine_); }
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  Vector3d vector() { return Vector3d(normal(), normal(), normal()); }
  Vector3d direction() { return vector().normalized(); }
  Quaterniond rotation() { return Quaterniond(normal(), normal(), normal(), normal()).normalized(); }

 private:
  std::mt19937 engine_;
  std::normal_distribution<double> normal_;
};

// R times a symmetric positive matrix has the best rotation R.
TEST(OracleRotation, PolarFactorIsFound) {
  Random random(1);
  for (int k = 0; k < 2000; ++k) {
    const Quaterniond R = random.rotation();
    const Matrix3d axes = random.rotation().toRotationMatrix();
    const Vector3d s(random.between(0.05, 1.0), random.between(0.05, 1.0), random.between(0.05, 1.0));
    const Matrix3d A = 1e-3 * R.toRotationMatrix() * axes * s.asDiagonal() * axes.transpose();
    // The gap s2 + s3 is at least a tenth of s1, so rounding of 2^-52 is amplified by about ten. The angle of
    // a quaternion product has a resolution of only 2e-8, so matrices are compared.
    EXPECT_LT((best_rotation(A, random.rotation()).toRotationMatrix() - R.toRotationMatrix()).norm(), 1e-13);
  }
}

// An inverted moment: the weakest axis is mirrored, and the result is a proper rotation.
TEST(OracleRotation, InversionGivesAProperRotation) {
  Random random(2);
  for (int k = 0; k < 2000; ++k) {
    const Quaterniond R = random.rotation();
    const Matrix3d axes = random.rotation().toRotationMatrix();
    const Matrix3d A = R.toRotationMatrix() * axes * Vector3d(1, 0.6, -0.3).asDiagonal() * axes.transpose();
    const Matrix3d found = best_rotation(A, random.rotation()).toRotationMatrix();
    EXPECT_NEAR(found.determinant(), 1.0, 1e-14);
    EXPECT_LT((found - R.toRotationMatrix()).norm(), 1e-13);  // gap 0.6 - 0.3
  }
}

// Brute force: no random rotation, near or far, has a larger trace(R^T A) than the one found.
TEST(OracleRotation, NoOtherRotationIsBetter) {
  Random random(3);
  for (int k = 0; k < 50; ++k) {
    Matrix3d A;
    for (int e = 0; e < 9; ++e) A(e) = random.normal();
    const Matrix3d R = best_rotation(A, random.rotation()).toRotationMatrix();
    const double best = (R.transpose() * A).trace();
    for (int other = 0; other < 500; ++other) {
      const double angle = std::pow(10.0, random.between(-4, 0.5));
      const Matrix3d Q = Eigen::AngleAxisd(angle, random.direction()) * R;
      EXPECT_LE((Q.transpose() * A).trace(), best + 1e-14 * A.norm());  // rounding of nine products
    }
  }
}

TEST(OracleRotation, OfTwoSignsTheQuaternionNearTheLastIsTaken) {
  Random random(4);
  for (int k = 0; k < 200; ++k) {
    const Quaterniond last = random.rotation();
    const Quaterniond step(Eigen::AngleAxisd(0.5, random.direction()));
    const Quaterniond found = best_rotation((step * last).toRotationMatrix(), last);
    EXPECT_GT(found.coeffs().dot(last.coeffs()), 0.9);  // cos(0.25)
  }
}

TEST(OracleRotation, NoMomentKeepsTheRotation) {
  Random random(5);
  const Quaterniond last = random.rotation();
  EXPECT_LT((best_rotation(Matrix3d::Zero(), last).coeffs() - last.coeffs()).norm(), 1e-15);
}

// A rank-1 moment s a b^T determines only that b maps to a. Of all such rotations, the nearest to the last
// one has no twist about a: the last one followed by the shortest arc.
TEST(OracleRotation, RankOneKeepsTheTwist) {
  Random random(6);
  for (int k = 0; k < 500; ++k) {
    const Vector3d a = random.direction();
    const Vector3d b = random.direction();
    const Quaterniond last = random.rotation();
    const Quaterniond found = best_rotation(0.3 * a * b.transpose(), last);
    EXPECT_LT((found * b - a).norm(), 1e-14);
    const Quaterniond arc = Quaterniond::FromTwoVectors(last * b, a);
    // For nearly opposite directions, rounding decides the arc's axis: 2^-52 over the distance to opposite.
    const double tolerance = 1e-13 / (1.0 + (last * b).dot(a));
    EXPECT_LT((found.toRotationMatrix() - (arc * last).toRotationMatrix()).norm(), tolerance);
  }
}

// A point reflection is equally far from every half turn; if the last rotation is one of the best, it stays.
TEST(OracleRotation, TiesOfAnInversionGoToTheNearest) {
  Random random(7);
  for (int k = 0; k < 200; ++k) {
    const Quaterniond last(Eigen::AngleAxisd(std::numbers::pi, random.direction()));
    EXPECT_LT((best_rotation(-Matrix3d::Identity(), last).coeffs() - last.coeffs()).norm(), 1e-15 * 8);
  }
  // The identity is a quarter turn of the quaternion away from all of them: the result may be any proper
  // rotation.
  const Matrix3d any = best_rotation(-Matrix3d::Identity(), Quaterniond::Identity()).toRotationMatrix();
  EXPECT_NEAR(any.determinant(), 1.0, 1e-14);
  EXPECT_NEAR(any.trace(), -1.0, 1e-14);
}

// A flat region (rank 2) has a unique best rotation, including its normal.
TEST(OracleRotation, RankTwoIsDetermined) {
  Random random(8);
  for (int k = 0; k < 500; ++k) {
    const Quaterniond R = random.rotation();
    const Matrix3d A = R.toRotationMatrix() * Vector3d(1, 0.4, 0).asDiagonal();
    EXPECT_LT((best_rotation(A, random.rotation()).toRotationMatrix() - R.toRotationMatrix()).norm(), 1e-13);
  }
}

// (8)(9)(10)(11): the goals of a rigidly moved body are its own positions, for any fibre and beta.
TEST(OracleGoal, RigidlyMovedBodyIsItsOwnGoal) {
  Random random(9);
  for (unsigned seed = 0; seed < 20; ++seed) {
    model::Model model = random_model(seed);
    const Points rest = rest_points(model);
    const cpu_reference::Weights weights = cpu_reference::region_weights(model);
    const Quaterniond R = random.rotation();
    const Vector3d t = random.vector();
    Points moved;
    for (const Vector3d& p : rest) moved.push_back(R * p + t);
    std::vector<cpu_reference::RegionPose> regions(model.vertex_count);
    for (std::uint32_t r = 0; r < model.vertex_count; ++r) {
      auto& region = regions[r];
      region.c0 = region_centre(weights, r, rest);
      region.c = region_centre(weights, r, moved);
      const Matrix3d A = region_moment(weights, r, region.T, rest, region.c0, moved, region.c);
      region.R = best_rotation(A, R);
    }
    Points goals;
    for (std::uint32_t i = 0; i < model.vertex_count; ++i)
      goals.push_back(blended_goal(weights, i, regions, rest, moved));
    // Coordinates of a few metres are rounded by 4e-16. In a region 0.1 m wide that is an error of 1e-14 in
    // its rotation, times about 1/(s2 + s3) if the weights are nearly collinear.
    EXPECT_LT(largest_distance(goals, moved), 1e-13) << "seed " << seed;
  }
}

TEST(OracleMuscle, ScaleKeepsVolume) {
  Random random(10);
  for (int k = 0; k < 1000; ++k) {
    const Vector3d n = random.direction();
    const double c = cpu_reference::muscle_stretch(random.between(0, 3) * random.between(-1, 1));
    const Matrix3d T = cpu_reference::muscle_scale(n, c);
    EXPECT_NEAR(T.determinant(), 1.0, 1e-14);  // about ten roundings of 2^-53, with c <= 4
    EXPECT_LT((T - T.transpose()).norm(), 1e-15);
    EXPECT_LT((T * n - c * n).norm(), 4e-15);
    const Vector3d across = n.unitOrthogonal();
    EXPECT_LT((T * across - across / std::sqrt(c)).norm(), 4e-15);
  }
}

TEST(OracleMuscle, SlackMuscleIsTheIdentity) {
  Random random(11);
  const Vector3d n = random.direction();
  EXPECT_EQ(cpu_reference::muscle_stretch(0.0), 1.0);
  EXPECT_LT((cpu_reference::muscle_scale(n, 1.0) - Matrix3d::Identity()).norm(), 1e-15);
  EXPECT_EQ(cpu_reference::muscle_scale(Vector3d::Zero(), 1.7), Matrix3d::Identity());
  EXPECT_EQ(cpu_reference::muscle_twist(n, n.unitOrthogonal(), 0.0), Matrix3d::Identity());
}

// (17) by hand, with its clamp.
TEST(OracleMuscle, StretchByHand) {
  EXPECT_DOUBLE_EQ(cpu_reference::muscle_stretch(0.75), 1.75);
  EXPECT_DOUBLE_EQ(cpu_reference::muscle_stretch(-0.25), 0.75);
  EXPECT_EQ(cpu_reference::muscle_stretch(9.0), 4.0);
  EXPECT_EQ(cpu_reference::muscle_stretch(-9.0), 0.25);
}

// Twisting a cylinder maps (rho, phi, s) to (rho, phi + k s, s). Its gradient, rotated back by k s, is the
// shear.
TEST(OracleMuscle, TwistIsThatOfACylinder) {
  const double k = 1.7, rho = 0.3, s = 0.4, phi = 0.9;
  const Vector3d axis(0, 0, 1), radial(std::cos(phi), std::sin(phi), 0.0), around = axis.cross(radial);
  const auto twisted = [&](const Vector3d& p) -> Vector3d { return Eigen::AngleAxisd(k * p.z(), axis) * p; };
  const Vector3d p = rho * radial + s * axis;
  Matrix3d gradient;
  const double step = 1e-6;  // central differences: error about step^2, and 1e-16 over the step
  for (int c = 0; c < 3; ++c)
    gradient.col(c) =
        (twisted(p + step * Vector3d::Unit(c)) - twisted(p - step * Vector3d::Unit(c))) / (2 * step);
  const Matrix3d shear = Eigen::AngleAxisd(-k * s, axis).toRotationMatrix() * gradient;
  const Matrix3d T = cpu_reference::muscle_twist(axis, around, k * rho);
  EXPECT_LT((shear - T).norm(), 1e-9);
  EXPECT_NEAR(T.determinant(), 1.0, 1e-15);
}

}  // namespace
}  // namespace fascicle::tests
