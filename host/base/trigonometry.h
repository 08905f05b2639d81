// Sine, cosine, arc cosine and exponential from + - * / sqrt and floor alone. The C library's own differ
// between CPU types in the last bit; whatever reaches a model or a drive uses these, so that it has the same
// bits on every machine.
#pragma once

namespace fascicle::base {

// Relative error below 1e-15 for |x| <= 1e6; throw std::domain_error beyond and for what is not a number.
double exact_sin(double x);
double exact_cos(double x);

// The angle in [0, pi] whose cosine is x, relative error below 1e-15. x is clamped to [-1, 1], because the
// dot product of two unit vectors may leave it by rounding. Throws std::domain_error for what is not a
// number.
double exact_acos(double x);

// e^x, relative error below 1e-15 where the result is a normal number; 0 and infinity beyond the range of
// double. Throws std::domain_error for what is not a number.
double exact_exp(double x);

}  // namespace fascicle::base
