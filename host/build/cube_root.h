// The cube root, the same on every machine.
#pragma once

#include <cmath>

namespace fascicle::build {

// Of x > 0, by Newton's iteration: the C library's cbrt may differ between machines, and the result becomes
// part of a model's bits.
inline double cube_root(double x) {
  int exponent = 0;
  const double mantissa = std::frexp(x, &exponent);
  double root = std::ldexp(mantissa, exponent / 3);
  for (int step = 0; step < 40; ++step) root -= (root - x / (root * root)) / 3.0;
  return root;
}

}  // namespace fascicle::build
