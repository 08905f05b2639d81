// Each numbered operation of kernel/self_test.inc computes what its number stands for. Devices are compared
// with that same file, so the self-test itself would not notice an operation that tests nothing.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <random>

#include <gtest/gtest.h>

#include "shaders/buffers.h"
#include "shaders/kernel/self_test.inc"

namespace fascicle::tests::self_test_operations_test {
namespace {

// A sum, difference or product of floats, rounded once to float: the detour over double does not change it,
// because a double has more than twice a float's bits (Figueroa, 1995).
float rounded_sum(float a, float b) {
  return static_cast<float>(double{a} + double{b});
}
float rounded_difference(float a, float b) {
  return static_cast<float>(double{a} - double{b});
}
float rounded_product(float a, float b) {
  return static_cast<float>(double{a} * double{b});
}
float snapped(float a) {
  return std::abs(a) < 0x1p-40f ? 0.0f : a;
}

using Scalar = std::function<float(float x, float y, float z, float w)>;

const std::array<Scalar, shader::self_test_scalars> scalars{
    [](float x, float y, float, float) { return rounded_sum(x, y); },
    [](float x, float y, float, float) { return rounded_difference(x, y); },
    [](float x, float y, float, float) { return rounded_product(x, y); },
    [](float x, float, float, float) { return std::copysign(x, std::signbit(x) ? 1.0f : -1.0f); },
    [](float x, float, float, float) { return snapped(x); },
    [](float x, float y, float, float) { return snapped(rounded_product(x, y)); },
    [](float x, float, float, float) { return std::fabs(x); },
    [](float x, float y, float z, float w) { return x < y ? z : w; },
    [](float x, float y, float z, float) { return rounded_sum(rounded_product(x, y), z); },
    [](float x, float y, float z, float w) {
      return rounded_difference(rounded_product(x, y), rounded_product(z, w));
    },
    [](float x, float y, float z, float) { return rounded_difference(z, rounded_product(x, y)); },
    [](float x, float y, float, float) { return rounded_difference(rounded_sum(x, y), x); },
    [](float x, float y, float z, float) {
      return rounded_sum(rounded_product(x, y), rounded_product(x, z));
    },
    [](float x, float y, float z, float) { return rounded_sum(rounded_sum(x, y), z); },
    [](float x, float y, float z, float) { return rounded_sum(x, rounded_sum(y, z)); },
    [](float x, float y, float z, float) { return rounded_product(rounded_product(x, y), z); },
    [](float x, float y, float z, float) { return rounded_product(x, rounded_product(y, z)); },
    [](float x, float y, float, float) {
      return rounded_sum(rounded_difference(x, y), rounded_difference(y, x));
    },
    [](float x, float y, float, float) { return -rounded_difference(x, y); }};

TEST(SelfTestOperations, OfAnyNumberAreRoundedOneByOne) {
  std::mt19937 random(1);
  // Products near 2^-40, where snap begins, and sums that lose bits.
  std::uniform_real_distribution<float> mantissa(-1.0f, 1.0f);
  std::uniform_int_distribution<int> exponent(-22, 0);
  const auto number = [&] { return std::ldexp(mantissa(random), exponent(random)); };
  for (int sample = 0; sample < 2000; ++sample) {
    const float x = sample % 7 == 0 ? std::ldexp(number(), -30) : number();
    const float y = number(), z = number(), w = number();
    for (std::size_t k = 0; k < scalars.size(); ++k) {
      const float found = kernel::self_test_scalar<float>(static_cast<int>(k), x, y, z, w);
      ASSERT_EQ(found, scalars[k](x, y, z, w))
          << "operation " << k << " of " << x << ", " << y << ", " << z << ", " << w;
    }
  }
}

// The largest relative errors that scalar.inc states, over two octaves, in which they repeat.
TEST(SelfTestOperations, OfAPositiveNumberAreItsReciprocals) {
  ASSERT_EQ(shader::self_test_positives, 3u);
  std::array<double, 3> worst{};
  for (float x = 1.0f; x < 4.0f; x += 0x1p-16f) {
    const std::array<double, 3> exact{1.0 / x, 1.0 / x, 1.0 / std::sqrt(double{x})};
    for (int k = 0; k < 3; ++k) {
      const auto at = static_cast<std::size_t>(k);
      worst[at] = std::max(worst[at], std::abs(kernel::self_test_positive<float>(k, x) / exact[at] - 1.0));
    }
  }
  EXPECT_NEAR(worst[0], 2.55e-3, 1e-5) << "one Newton step from a seed within 5.05 %: its square";
  EXPECT_LE(worst[1], 1.0e-7) << "four steps: rounding alone";
  EXPECT_LE(worst[2], 1.5e-7) << "three steps: 2.2 ULP, each at most 1.2e-7 and at least half of that";
}

}  // namespace
}  // namespace fascicle::tests::self_test_operations_test
