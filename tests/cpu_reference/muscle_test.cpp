// The float muscle matrices of kernel/muscle.inc compared with the oracle's in double, entry by entry.
#include "shaders/kernel/muscle.inc"

#include <algorithm>
#include <array>
#include <random>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "cpu_reference/oracle/oracle_equations.h"

namespace fascicle::tests::muscle_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Entries are at most 4, the largest stretch, and a shear of 2 times 4. Each takes some ten roundings of
// 6e-8, and reciprocal_sqrt 2.2 ULP.
constexpr double rounding = 8.0 * 16.0 * 6e-8;

kernel::Vector<float> as_floats(const Vector3d& v) {
  return {float(v.x()), float(v.y()), float(v.z())};
}

Matrix3d as_doubles(const kernel::Matrix<float>& m) {
  Matrix3d made;
  made << m.xx, m.xy, m.xz, m.yx, m.yy, m.yz, m.zx, m.zy, m.zz;
  return made;
}

struct Sample {
  Vector3d fibre, axis, around;  // unit vectors; the last is perpendicular to the axis
  double bulge, shear;
};

Sample random_sample(std::mt19937& engine) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  const auto direction = [&] {
    return Vector3d(normal(engine), normal(engine), normal(engine)).normalized();
  };
  Sample sample{direction(), direction(), {}, 5.0 * any(engine), 2.0 * any(engine)};
  sample.around = sample.axis.cross(direction()).normalized();
  return sample;
}

TEST(Muscle, ScalesAsTheOracleDoes) {
  std::mt19937 engine(1);
  bool is_clamped_below = false, is_clamped_above = false;
  for (int k = 0; k < 2000; ++k) {
    const Sample s = random_sample(engine);
    const double c = cpu_reference::muscle_stretch(s.bulge);
    is_clamped_below |= c == 0.25;
    is_clamped_above |= c == 4.0;
    const Matrix3d found = as_doubles(kernel::muscle_scale<float>(as_floats(s.fibre), float(s.bulge)));
    ASSERT_LE((found - cpu_reference::muscle_scale(s.fibre, c)).cwiseAbs().maxCoeff(), rounding) << s.bulge;
  }
  EXPECT_TRUE(is_clamped_below && is_clamped_above);
}

TEST(Muscle, TwistsAsTheOracleDoes) {
  std::mt19937 engine(2);
  for (int k = 0; k < 2000; ++k) {
    const Sample s = random_sample(engine);
    const kernel::Matrix<float> scale = kernel::muscle_scale<float>(as_floats(s.fibre), float(s.bulge));
    const Matrix3d expected = cpu_reference::muscle_twist(s.axis, s.around, s.shear) *
                              cpu_reference::muscle_scale(s.fibre, cpu_reference::muscle_stretch(s.bulge));
    const Matrix3d found = as_doubles(
        kernel::muscle_twist<float>(scale, as_floats(s.axis), as_floats(s.around), float(s.shear)));
    ASSERT_LE((found - expected).cwiseAbs().maxCoeff(), rounding) << s.bulge << ", " << s.shear;
  }
}

// Equation (17): the contraction's component along the fibre, and the swelling, times the gain.
TEST(Muscle, BulgesByWhatContractsAlongTheFibre) {
  std::mt19937 engine(3);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (int k = 0; k < 2000; ++k) {
    const Sample s = random_sample(engine);
    const double swell = any(engine);
    const double expected = s.bulge * (s.fibre.dot(3.0 * s.axis) + swell);
    EXPECT_NEAR(kernel::muscle_bulge<float>(as_floats(s.fibre), float(s.bulge), as_floats(3.0 * s.axis),
                                            float(swell)),
                expected, 5.0 * 4.0 * 8.0 * 6e-8);
  }
}

}  // namespace
}  // namespace fascicle::tests::muscle_test
