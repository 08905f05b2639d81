// Sine, cosine, arc cosine and exponential from + - * / sqrt and floor alone. The C library's versions differ
// between CPU types in the last bit. Everything that reaches a model or a drive uses these, so that it has
// the same bits on every machine.
#pragma once

namespace fascicle::base {

// Relative error below 1e-15 for |x| <= 1e6. Throw std::domain_error beyond that and for NaN.
double exact_sin(double x);
double exact_cos(double x);

// The angle in [0, pi] whose cosine is x, relative error below 1e-15. x is clamped to [-1, 1], because
// rounding may take the dot product of two unit vectors outside it. Throws std::domain_error for NaN.
double exact_acos(double x);

// e^x, relative error below 1e-15 if the result is a normal number; 0 and infinity beyond the range of
// double. Throws std::domain_error for NaN.
double exact_exp(double x);

}  // namespace fascicle::base
