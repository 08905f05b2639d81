#include "host/base/trigonometry.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>

namespace fascicle::base {
namespace {

// A constant split into pieces whose products with a small whole number are exact, so that subtracting them
// one after the other loses nothing, however near x is to a multiple of the constant.
constexpr double half_pi_1 = 0x1.921fb544p+0;   // 33 bits
constexpr double half_pi_2 = 0x1.0b4611a6p-34;  // the next 32
constexpr double half_pi_3 = 0x1.3198a2ep-69;   // the next 30
constexpr double half_pi_4 = 0x1.b839a252049c1p-104;
constexpr double half_pi = 0x1.921fb54442d18p+0;
constexpr double half_pi_rest = 0x1.1a62633145c07p-54;

constexpr double ln2_1 = 0x1.62e42feep-1;  // 32 bits
constexpr double ln2_2 = 0x1.a39ef35793c76p-33;

constexpr double largest_angle = 1e6;

// x = quarter * pi/2 + rest, |rest| <= pi/4.
struct Reduced {
  double rest;
  std::int64_t quarter;
};

Reduced reduce(double x) {
  if (!(x >= -largest_angle && x <= largest_angle)) {
    throw std::domain_error("an angle must be a number between -1e6 and 1e6 radians");
  }
  const double n = std::floor(x / half_pi + 0.5);
  const double rest = (((x - n * half_pi_1) - n * half_pi_2) - n * half_pi_3) - n * half_pi_4;
  return {rest, static_cast<std::int64_t>(n)};
}

// Taylor series, nested: 1 - x^2/(2 3) (1 - x^2/(4 5) (...)). On |x| <= pi/4 the first term left out is below
// 1e-19.
double sin_series(double x) {
  const double square = x * x;
  double sum = 1.0;
  for (int n = 8; n >= 1; --n) sum = 1.0 - square / static_cast<double>((2 * n) * (2 * n + 1)) * sum;
  return x * sum;
}

double cos_series(double x) {
  const double square = x * x;
  double sum = 1.0;
  for (int n = 9; n >= 1; --n) sum = 1.0 - square / static_cast<double>((2 * n - 1) * (2 * n)) * sum;
  return sum;
}

// Nested like the above: asin x = x (1 + 1/(2 3) x^2 (1 + 9/(4 5) x^2 (...))). For |x| <= 1/2 each term is
// below a quarter of the previous one, and the first term left out is below 1e-19.
double asin_series(double x) {
  const double square = x * x;
  double sum = 1.0;
  for (int n = 28; n >= 1; --n) {
    const double odd = static_cast<double>(2 * n - 1);
    sum = 1.0 + (odd * odd) / static_cast<double>((2 * n) * (2 * n + 1)) * square * sum;
  }
  return x * sum;
}

double power_of_two(int exponent) {  // of a normal number
  return std::bit_cast<double>(static_cast<std::uint64_t>(exponent + 1023) << 52);
}

}  // namespace

double exact_sin(double x) {
  const Reduced r = reduce(x);
  switch (r.quarter & 3) {
    case 0:
      return sin_series(r.rest);
    case 1:
      return cos_series(r.rest);
    case 2:
      return -sin_series(r.rest);
    default:
      return -cos_series(r.rest);
  }
}

double exact_cos(double x) {
  const Reduced r = reduce(x);
  switch (r.quarter & 3) {
    case 0:
      return cos_series(r.rest);
    case 1:
      return -sin_series(r.rest);
    case 2:
      return -cos_series(r.rest);
    default:
      return sin_series(r.rest);
  }
}

double exact_acos(double x) {
  if (x != x) throw std::domain_error("the arc cosine of NaN");
  if (x >= 1.0) return 0.0;
  if (x <= -1.0) return 2.0 * half_pi;
  // Beyond +-1/2 the series is too short, and near 1 pi/2 - asin x would cancel: the half angle's sine keeps
  // its digits, and 1 - |x| is exact there.
  if (x > 0.5) return 2.0 * asin_series(std::sqrt((1.0 - x) * 0.5));
  if (x < -0.5) return 2.0 * (half_pi - (asin_series(std::sqrt((1.0 + x) * 0.5)) - half_pi_rest));
  return half_pi - (asin_series(x) - half_pi_rest);
}

double exact_exp(double x) {
  if (x != x) throw std::domain_error("the exponential of NaN");
  if (x > 710.0) return std::numeric_limits<double>::infinity();
  if (x < -746.0) return 0.0;
  const double n = std::floor(x / (ln2_1 + ln2_2) + 0.5);
  const double rest = (x - n * ln2_1) - n * ln2_2;
  // |rest| <= ln2 / 2: the first term left out is below 1e-18.
  double sum = 1.0;
  for (int k = 14; k >= 1; --k) sum = 1.0 + rest / static_cast<double>(k) * sum;
  // In two steps: 2^n alone may be out of range for a normal number when the result is not.
  const int exponent = static_cast<int>(n);
  const int half = exponent / 2;
  return sum * power_of_two(half) * power_of_two(exponent - half);
}

}  // namespace fascicle::base
