// The start of the implicit iterations, kernel/predict.inc, compared with its formula in double. It moves
// only the start, so comparisons of whole substeps hardly see a mistake in it.
#include "shaders/kernel/predict.inc"

#include <algorithm>
#include <random>

#include <Eigen/Core>
#include <gtest/gtest.h>

namespace fascicle::tests::predict_test {
namespace {

using Eigen::Vector3d;

kernel::Vector<float> as_floats(const Vector3d& v) {
  return {float(v.x()), float(v.y()), float(v.z())};
}

struct Start {
  Vector3d position, velocity, before, acceleration, u;
  double h, start, share, kept, dragged;
};

// v + s (c (v - v_prev) + (1 - c) h p f/|f|), damped, from q over h (predict.inc).
Vector3d expected(const Start& s) {
  const Vector3d gained = s.velocity - s.before;
  const double force = s.acceleration.norm();
  Vector3d fall = Vector3d::Zero();
  if (force > 0.0) {
    const Vector3d along = s.acceleration / force;
    fall = std::clamp(gained.dot(along) / s.h, 0.0, force) * along;
  }
  const Vector3d v = s.velocity + s.start * (s.share * gained + (1.0 - s.share) * s.h * fall);
  return s.position + s.h * (s.kept * v + s.dragged * s.u);
}

TEST(Predict, StartsAsTheFormulaSays) {
  std::mt19937 engine(4);
  std::uniform_real_distribution<double> any(-1.0, 1.0), part(0.0, 1.0);
  const auto vector = [&](double size) -> Vector3d {
    return Vector3d(any(engine), any(engine), any(engine)) * size;
  };
  std::size_t fully = 0, partly = 0, none = 0;
  for (int k = 0; k < 4000; ++k) {
    Start s{.position = vector(1.0),
            .velocity = vector(2.0),
            .before = {},
            .acceleration = vector(20.0),
            .u = vector(2.0),
            .h = 1.0 / 256,
            .start = 0.5 + 0.5 * part(engine),
            .share = part(engine),
            .kept = part(engine),
            .dragged = part(engine)};
    // Gains of up to 1.5 times what the acceleration gives, and down to its opposite; then anything.
    s.before = s.velocity - 1.5 * any(engine) * s.h * s.acceleration - vector(k % 2 ? 0.02 : 0.0);
    if (k % 5 == 0) s.acceleration.setZero();
    if (k % 7 == 0) s.share = k % 2;
    const double gain = s.acceleration.norm() > 0.0 ? (s.velocity - s.before).dot(s.acceleration) /
                                                          (s.h * s.acceleration.squaredNorm())
                                                    : 0.0;
    ++(gain <= 0.0 ? none : gain < 1.0 ? partly : fully);
    const auto found =
        kernel::start_position<float>(as_floats(s.position), as_floats(s.velocity), as_floats(s.before),
                                      as_floats(s.acceleration), as_floats(s.u), float(s.h), float(1.0 / s.h),
                                      float(s.start), float(s.share), float(s.kept), float(s.dragged));
    // Coordinates below 2 are rounded by 2^-24, and what is added to them, below 0.02, by some 2^-28.
    EXPECT_LE((Vector3d(found.x, found.y, found.z) - expected(s)).cwiseAbs().maxCoeff(), 1.5e-7) << k;
  }
  EXPECT_GT(none, 500u);
  EXPECT_GT(partly, 500u);
  EXPECT_GT(fully, 200u);
}

}  // namespace
}  // namespace fascicle::tests::predict_test
