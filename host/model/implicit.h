// What the host computes for the implicit integrator, once a step length. Double precision, + - * / and sqrt,
// rounded once: the same on every machine.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/model/model.h"
#include "host/model/solver.h"
#include "shaders/shared.h"

namespace fascicle::model {

// How far an iteration goes: x <- x_prev + omega (gain (x_hat - x) + x - x_prev).
struct Relaxation {
  float omega = 1.0f, gain = 1.0f;
};

// What the solvers keep for a step length. Of backward Euler first, then of BDF2;
// ImplicitStep::first_response points to the one or the other.
struct ImplicitTables {
  double h = 0.0;                                      // s; 0: not made yet
  std::vector<shader::Response> responses;             // 2n
  std::array<std::vector<Relaxation>, 2> relaxations;  // of each iteration
  double extrapolated = 0.0;                           // with history
};
ImplicitTables implicit_tables(const Model& model, const SolverOptions& options, double h);

// A substep's numbers: BDF2's with history, backward Euler's without. omega and gain are left 1.
shader::ImplicitStep implicit_step(const Model& model, const ImplicitTables& tables, bool with_history);

// The error's modes shrink by factors from 0 (rough) to `stiffest`, the largest a of a vertex (smooth), an
// iteration. Chebyshev's polynomial that is small on all of [0, a_N], with a_N so that it is 1/20 there, is
// the best that iterations can do, and more than is needed where no a reaches a_N. Modes beyond a_N, of
// bodies so stiff that the iterations do not reach across them, converge over several substeps. The last
// iteration is a plain one, which takes away what rounding left in rough modes.
//
// A volume term sends modes beyond their goal, by up to `overshoot` times `stiffest` of their error. Only a
// share of each pass is taken then, such that their factors are 0 again at the least.
std::vector<Relaxation> relaxations(std::uint32_t iterations, double stiffest, double overshoot = 0.0);

// The share of the last substep's acceleration from which the iterations go on: 1 where they resolve the
// largest a, `stiffest`, and falling with the stiffness K H^2 / m = a / (1 - a) where they do not.
double extrapolated_share(std::uint32_t iterations, double stiffest);

// The square root of the largest K H^2 / m whose modes the iterations reduce to 1/20.
double resolved_stiffness(std::uint32_t iterations);

// The share of an error in the smoothest mode that is left after the iterations, where K H^2/m is `stiffness`
// on the whole body. At most resolved_residual where they resolve it and nothing overshoots.
double residual_share(std::uint32_t iterations, double stiffness, double overshoot = 0.0);
inline constexpr double resolved_residual = 1.0 / 20.0;

// How far beyond rest the volume term sends a mode, of its error.
double volume_overshoot(const Model& model);

}  // namespace fascicle::model
