// The float rotation extraction of kernel/rotation.inc compared with the SVD in double.
#include "shaders/kernel/rotation.inc"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "cpu_reference/oracle/oracle_equations.h"

namespace fascicle::tests::rotation_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr int samples = 20000;
constexpr double degrees = 180.0 / std::numbers::pi;

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double normal() { return normal_(engine_); }
  Vector3d direction() { return Vector3d(normal(), normal(), normal()).normalized(); }
  Quaterniond rotation() { return Quaterniond(normal(), normal(), normal(), normal()).normalized(); }
  Matrix3d matrix() {
    Matrix3d m;
    for (int k = 0; k < 9; ++k) m(k) = normal();
    return m;
  }

 private:
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_;
};

kernel::Matrix<float> to_float(const Matrix3d& m) {
  return {float(m(0, 0)), float(m(0, 1)), float(m(0, 2)), float(m(1, 0)), float(m(1, 1)),
          float(m(1, 2)), float(m(2, 0)), float(m(2, 1)), float(m(2, 2))};
}

kernel::Quaternion<float> to_float(const Quaterniond& q) {
  return {float(q.w()), float(q.x()), float(q.y()), float(q.z())};
}

Quaterniond to_double(const kernel::Quaternion<float>& q) {
  return Quaterniond(q.w, q.x, q.y, q.z);
}

// Accurate for small angles too, unlike the arc cosine of a dot product.
double angle_between(const Quaterniond& a, const Quaterniond& b) {
  const Quaterniond d = a.conjugate() * b;
  return 2.0 * std::atan2(d.vec().norm(), std::abs(d.w())) * degrees;
}

// Moments as they occur in regions: singular values `s` in any frame at rest, strained by normal deviates of
// size `strain`, then rotated by `jump` degrees since the last substep. The last numbers are the largest
// errors, in degrees, allowed for `qcp` and for `mueller2016`.
struct Category {
  const char* name;
  Vector3d s;
  double jump;
  double strain;
  double qcp;
  double mueller;
};

// The bounds for qcp are five times the worst of 20,000 samples (2.9e-5, and 7e-5 if s2 + s3 is small
// relative to s1): a float quaternion is accurate to 2^-24, which is 7e-6 degrees, and the moment's rounding
// adds that over (s2 + s3)/s1. Those for mueller2016 are one and a half times the measured worst: eight steps
// with linear convergence. It lags on anisotropic moments, which fibre weights produce; hence it is not the
// default.
const Category categories[] = {
    {"isotropic, 1 degree", {1, 1, 1}, 1, 0.1, 1.5e-4, 0.03},
    {"isotropic, 10 degrees", {1, 1, 1}, 10, 0.1, 1.5e-4, 0.05},
    {"isotropic, 30 degrees", {1, 1, 1}, 30, 0.1, 1.5e-4, 0.09},
    {"(1, .2, .1), 1 degree", {1, 0.2, 0.1}, 1, 0.02, 1.5e-4, 0.75},
    {"(1, .2, .1), 30 degrees", {1, 0.2, 0.1}, 30, 0.02, 1.5e-4, 6.5},
    {"(1, .05, .02), 1 degree", {1, 0.05, 0.02}, 1, 0.002, 3.5e-4, 1.1},
    {"(1, .05, .02), 10 degrees", {1, 0.05, 0.02}, 10, 0.002, 3.5e-4, 9.0},
    {"(1, .05, .02), 30 degrees", {1, 0.05, 0.02}, 30, 0.002, 3.5e-4, 27.0},
    {"isotropic, 170 degrees", {1, 1, 1}, 170, 0.1, 1.5e-4, 180.0},
    {"(1, .2, .1), 170 degrees", {1, 0.2, 0.1}, 170, 0.02, 1.5e-4, 180.0},
    {"inverted (1, .6, -.3), 10 degrees", {1, 0.6, -0.3}, 10, 0.0, 3.5e-4, 1.9},
};

struct Errors {
  double worst = 0.0;         // degrees
  double mean = 0.0;          // degrees
  double worst_length = 0.0;  // |q| - 1
  int near_half_turn = 0;     // samples skipped
};

Errors measure(const Category& category, bool mueller) {
  Random random(3);
  Errors errors;
  for (int k = 0; k < samples; ++k) {
    const Quaterniond last = random.rotation();
    const Quaterniond turn(Eigen::AngleAxisd(category.jump / degrees, random.direction()));
    const Matrix3d axes = random.rotation().toRotationMatrix();
    const Matrix3d at_rest = axes * category.s.asDiagonal() * axes.transpose();
    const Matrix3d strain = Matrix3d::Identity() + category.strain * random.matrix();
    // Any size: the mean region has |A| = 1, others are powers of ten around it.
    const double size = std::pow(10.0, 3.0 * std::clamp(random.normal(), -2.0, 2.0));
    const kernel::Matrix<float> A =
        to_float(Matrix3d(size * ((turn * last).toRotationMatrix() * strain * at_rest)));
    Matrix3d exact;
    exact << A.xx, A.xy, A.xz, A.yx, A.yy, A.yz, A.zx, A.zy, A.zz;
    const Quaterniond best = cpu_reference::best_rotation(exact, last);
    // There the start and the best rotation are orthogonal quaternions, and the iteration begins in the wrong
    // subspace.
    if (angle_between(last, best) > 179.9) {
      ++errors.near_half_turn;
      continue;
    }
    const Quaterniond found = to_double(kernel::extract_rotation<float>(to_float(last), A, mueller));
    const double error = angle_between(found.normalized(), best);
    if (!(error <= errors.worst)) errors.worst = error;  // lets a NaN in
    errors.mean += error / samples;
    const double length = std::abs(found.norm() - 1.0);
    if (!(length <= errors.worst_length)) errors.worst_length = length;
  }
  return errors;
}

TEST(Rotation, QcpIsTheSvdToFloatAccuracy) {
  for (const Category& category : categories) {
    const Errors errors = measure(category, false);
    EXPECT_LT(errors.worst, category.qcp) << category.name;
    EXPECT_LT(errors.mean, category.qcp / 5.0) << category.name;
    EXPECT_LT(errors.worst_length, 5e-7)
        << category.name;  // 2e-7 measured: rsqrt's 1.5 ULP and the product's rounding
    EXPECT_LT(errors.near_half_turn, samples / 100) << category.name;
  }
}

TEST(Rotation, Mueller2016LagsOnAnisotropicMoments) {
  for (const Category& category : categories) {
    const Errors errors = measure(category, true);
    EXPECT_LT(errors.worst, category.mueller) << category.name;
    EXPECT_LT(errors.worst_length, 5e-7) << category.name;
    if (category.s.y() < 0.5 && category.jump >= 10) {
      EXPECT_GT(errors.mean, 1.0) << category.name;
    }
  }
}

// Iterated from frame to frame on the same moment it converges: the lag is due to the eight steps, not the
// method.
TEST(Rotation, Mueller2016ArrivesInTheEnd) {
  Random random(5);
  for (int k = 0; k < 200; ++k) {
    const Quaterniond last = random.rotation();
    const Quaterniond turn(Eigen::AngleAxisd(30 / degrees, random.direction()));
    const Matrix3d axes = random.rotation().toRotationMatrix();
    const Matrix3d exact =
        (turn * last).toRotationMatrix() * axes * Vector3d(1, 0.2, 0.1).asDiagonal() * axes.transpose();
    kernel::Quaternion<float> q = to_float(last);
    for (int frame = 0; frame < 40; ++frame) q = kernel::extract_rotation<float>(q, to_float(exact), true);
    EXPECT_LT(angle_between(to_double(q).normalized(), turn * last),
              1e-3);  // float steps stop within about 2^-24/(s2 + s3)
  }
}

// A hundredth of a degree from a half turn, the start contains almost nothing of the answer (a cosine of
// 9e-5), and each step multiplies that by about 1e5: two steps still find it. Worst measured 5.6e-5; the
// bound is five times that. At exactly half a turn, start and answer are orthogonal, and the rotation may
// stay for a substep.
TEST(Rotation, QcpTurnsByNearlyHalfATurn) {
  Random random(6);
  for (int k = 0; k < samples; ++k) {
    const Quaterniond last = random.rotation();
    const Quaterniond turn(Eigen::AngleAxisd(179.99 / degrees, random.direction()));
    const Matrix3d exact = (turn * last).toRotationMatrix() * Vector3d(1, 0.8, 0.6).asDiagonal();
    const Quaterniond best = cpu_reference::best_rotation(exact, last);
    const Quaterniond found =
        to_double(kernel::extract_rotation<float>(to_float(last), to_float(exact), false));
    EXPECT_LT(angle_between(found.normalized(), best), 3e-4);
  }
}

// A rank-1 moment a b^T determines where b goes but not the twist, which is kept: the answer is the rotation
// nearest to the last that takes b to a. There the quartic has a double root, to which Newton's steps only
// halve the distance: 6 steps leave about 0.01 to 0.02 of it, so two inverse iterations leave 1.1e-2 degrees
// x tan(jump/2), measured, plus the rounding error of a double root (1.2e-3). The twist never changes by
// more.
TEST(Rotation, QcpKeepsTheTwistOfARankOneMoment) {
  for (double jump : {0.0, 1.0, 10.0, 30.0, 90.0, 170.0}) {
    Random random(4);
    double worst = 0.0;
    for (int k = 0; k < samples; ++k) {
      const Quaterniond last = random.rotation();
      const Vector3d b = random.direction();
      const Vector3d before = last * b;
      const Vector3d across = before.cross(random.direction()).normalized();
      const Vector3d a = Eigen::AngleAxisd(jump / degrees, across) * before;
      const Matrix3d exact = a * b.transpose();
      const Quaterniond best = cpu_reference::best_rotation(exact, last);
      const Quaterniond found =
          to_double(kernel::extract_rotation<float>(to_float(last), to_float(exact), false));
      worst = std::max(worst, angle_between(found.normalized(), best));
    }
    EXPECT_LT(worst, 2e-3 + 1.5e-2 * std::tan(jump / 2.0 / degrees)) << jump;
  }
}

// A zero moment, or less than 2^-40 of a typical moment at rest, keeps the rotation's bits; slightly more
// changes it.
TEST(Rotation, TooSmallAMomentKeepsTheRotation) {
  Random random(7);
  for (bool mueller : {false, true})
    for (int k = 0; k < 1000; ++k) {
      const kernel::Quaternion<float> last = to_float(random.rotation());
      const auto kept = [&](const Matrix3d& moment) {
        const kernel::Quaternion<float> q = kernel::extract_rotation<float>(last, to_float(moment), mueller);
        return q.w == last.w && q.x == last.x && q.y == last.y && q.z == last.z;
      };
      const Matrix3d moment = random.rotation().toRotationMatrix() * Vector3d(1, 0.5, 0.25).asDiagonal();
      const Matrix3d unit = moment / moment.norm();
      EXPECT_TRUE(kept(Matrix3d::Zero()));
      EXPECT_TRUE(kept(std::ldexp(0.99, -40) * unit));
      EXPECT_TRUE(kept(std::ldexp(1.0, -70) * unit));  // squares are denormal or zero
      EXPECT_FALSE(kept(std::ldexp(1.01, -40) * unit));
    }
}

}  // namespace
}  // namespace fascicle::tests::rotation_test
