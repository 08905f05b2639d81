#include "host/base/trigonometry.h"

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

namespace fascicle::tests {
namespace {

using base::exact_acos;
using base::exact_cos;
using base::exact_exp;
using base::exact_sin;

// The header's promise. References are long double, 11 bits more precise.
constexpr double promised = 1e-15;

double relative_error(double value, long double truth) {
  if (truth == 0.0L) return value == 0.0 ? 0.0 : std::numeric_limits<double>::infinity();
  return static_cast<double>(std::fabs((static_cast<long double>(value) - truth) / truth));
}

TEST(Trigonometry, sine_and_cosine_of_any_angle) {
  std::mt19937_64 random(1);
  double worst = 0.0;
  for (const double range : {1e-12, 1e-3, 0.8, 7.0, 1e3, 1e6}) {
    std::uniform_real_distribution<double> angles(-range, range);
    for (int i = 0; i < 100000; ++i) {
      const double x = angles(random);
      worst = std::max(worst, relative_error(exact_sin(x), std::sin(static_cast<long double>(x))));
      worst = std::max(worst, relative_error(exact_cos(x), std::cos(static_cast<long double>(x))));
    }
  }
  EXPECT_LT(worst, promised);
}

// Next to multiples of pi/2, cancellation in one of the two is nearly total: the result consists of digits of
// pi beyond double precision.
TEST(Trigonometry, sine_and_cosine_beside_the_multiples_of_a_quarter_turn) {
  double worst = 0.0;
  const long double quarter = std::acos(0.0L);
  for (int k = 1; k < 600000; k += 7) {
    const double x = static_cast<double>(static_cast<long double>(k) * quarter);
    for (const double y : {std::nextafter(x, 0.0), x, std::nextafter(x, 1e7)}) {
      worst = std::max(worst, relative_error(exact_sin(y), std::sin(static_cast<long double>(y))));
      worst = std::max(worst, relative_error(exact_cos(y), std::cos(static_cast<long double>(y))));
    }
  }
  EXPECT_LT(worst, promised);
}

TEST(Trigonometry, known_values) {
  EXPECT_EQ(exact_sin(0.0), 0.0);
  EXPECT_EQ(exact_cos(0.0), 1.0);
  EXPECT_EQ(exact_acos(1.0), 0.0);
  EXPECT_EQ(exact_acos(-1.0), 0x1.921fb54442d18p+1);
  EXPECT_EQ(exact_acos(0.0), 0x1.921fb54442d18p+0);
  EXPECT_EQ(exact_exp(0.0), 1.0);
}

TEST(Trigonometry, arc_cosine_over_its_whole_domain) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> all(-1.0, 1.0), exponent(-53.0, 0.0);
  double worst = 0.0;
  for (int i = 0; i < 300000; ++i) {
    for (const double x : {all(random), 1.0 - std::exp2(exponent(random)), std::exp2(exponent(random)) - 1.0,
                           std::exp2(exponent(random)), std::nextafter(1.0, 0.0)}) {
      worst = std::max(worst, relative_error(exact_acos(x), std::acos(static_cast<long double>(x))));
    }
  }
  EXPECT_LT(worst, promised);
  EXPECT_EQ(exact_acos(1.0 + 1e-9), 0.0);
  EXPECT_EQ(exact_acos(-1.0 - 1e-9), exact_acos(-1.0));
}

TEST(Trigonometry, exponential) {
  std::mt19937_64 random(3);
  double worst = 0.0;
  for (const double range : {1e-9, 0.1, 1.0, 30.0, 700.0}) {
    std::uniform_real_distribution<double> exponents(-range, range);
    for (int i = 0; i < 100000; ++i) {
      const double x = exponents(random);
      worst = std::max(worst, relative_error(exact_exp(x), std::exp(static_cast<long double>(x))));
    }
  }
  EXPECT_LT(worst, promised);
  EXPECT_EQ(exact_exp(-1e300), 0.0);
  EXPECT_EQ(exact_exp(1e300), std::numeric_limits<double>::infinity());
  EXPECT_TRUE(std::isfinite(exact_exp(709.7)));
  // Below the normal numbers, accuracy is limited to one unit in the last place.
  const double subnormal = exact_exp(-740.0), truth = static_cast<double>(std::exp(-740.0L));
  EXPECT_LE(std::abs(subnormal - truth), std::numeric_limits<double>::denorm_min());
}

TEST(Trigonometry, refuses_what_is_not_a_number_and_angles_beyond_its_reduction) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(exact_sin(nan), std::domain_error);
  EXPECT_THROW(exact_cos(1.1e6), std::domain_error);
  EXPECT_THROW(exact_sin(-std::numeric_limits<double>::infinity()), std::domain_error);
  EXPECT_THROW(exact_acos(nan), std::domain_error);
  EXPECT_THROW(exact_exp(nan), std::domain_error);
}

}  // namespace
}  // namespace fascicle::tests
