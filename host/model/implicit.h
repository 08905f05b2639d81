// What the host computes for the implicit integrator, once per step length. Double precision, + - * / and
// sqrt, rounded once: the same on every machine.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/model/model.h"
#include "host/model/solver.h"
#include "shaders/shared.h"

namespace fascicle::model {

// The step of one iteration: x <- x_prev + omega (gain (x_hat - x) + x - x_prev).
struct Relaxation {
  float omega = 1.0f, gain = 1.0f;
};

// The share t of BDF2 in a step of h seconds; the rest is backward Euler:
//   q' = (1 - t) (q - q_prev)/h + t (3 q - 4 q_prev + q_before)/(2h).
// Of a motion w (rad/s) this takes (1 - t) h w^2/2 per second, which is what the viscosity asks for. It
// cannot give more than backward Euler does, so at most h of the viscosity counts.
double second_order_share(double viscosity, double h);

// What the solvers keep for a step length: entries for backward Euler first, which a step without history
// takes, then for the blend with BDF2. ImplicitStep::first_response selects between them.
struct ImplicitTables {
  double h = 0.0;                                      // s; 0: not computed yet
  double second_order = 1.0;                           // with history
  std::vector<shader::Response> responses;             // 2n
  std::array<std::vector<Relaxation>, 2> relaxations;  // one per iteration
  double extrapolated = 0.0;                           // with history
};
ImplicitTables implicit_tables(const Model& model, const SolverOptions& options, double h);

// A substep's numbers: with history for the blend of the tables, without for backward Euler. omega and gain
// are left at 1.
shader::ImplicitStep implicit_step(const Model& model, const ImplicitTables& tables, bool with_history);

// In each iteration the modes of the error shrink by factors from 0 (rough) to `stiffest`, the largest a of
// any vertex (smooth). The best that N iterations can do is the Chebyshev polynomial that is small on all of
// [0, a_N], with a_N chosen so that it is 1/20 there. If no a reaches a_N, a smaller band is used. Modes
// beyond a_N, in bodies too stiff for the iterations to propagate across, converge over several substeps. The
// last iteration is not over-relaxed, to remove rounding errors from rough modes.
//
// A volume term makes modes overshoot their goal, by up to `overshoot` times `stiffest` of their error. Each
// pass is then scaled down so that the smallest factor is 0 again.
std::vector<Relaxation> relaxations(std::uint32_t iterations, double stiffest, double overshoot = 0.0);

// The share of the last substep's acceleration by which the starting guess is extrapolated: 1 if the
// iterations resolve the largest a, `stiffest`; otherwise it falls with the stiffness K H^2 / m = a / (1 -
// a).
double extrapolated_share(std::uint32_t iterations, double stiffest);

// The square root of the largest K H^2 / m whose modes the iterations reduce to 1/20.
double resolved_stiffness(std::uint32_t iterations);

// The share of an error in the smoothest mode that remains after the iterations if K H^2/m is `stiffness` on
// the whole body. At most resolved_residual if they resolve it and nothing overshoots.
double residual_share(std::uint32_t iterations, double stiffness, double overshoot = 0.0);
inline constexpr double resolved_residual = 1.0 / 20.0;

// How far the volume term makes a mode overshoot rest, as a share of its error.
double volume_overshoot(const Model& model);

}  // namespace fascicle::model
