// What the host computes for the implicit integrator, once a step length: method "Time step". Double
// precision,
// + - * / only, rounded once: the same on every machine.
#pragma once

#include <cstdint>
#include <vector>

#include "host/model/model.h"
#include "host/model/solver.h"
#include "shaders/shared.h"

namespace fascicle::model {

// The substep's numbers for h seconds: BDF2 with history, backward Euler without. omega and gain are left 1.
shader::ImplicitStep implicit_step(const Model& model, double h, bool with_history);

// Each vertex's Response: n for backward Euler, then n for BDF2. ImplicitStep::first_response points into
// them.
std::vector<shader::Response> responses(const Model& model, double h);

// How far an iteration goes: x <- x_prev + omega (gain (x_hat - x) + x - x_prev).
struct Relaxation {
  float omega = 1.0f, gain = 1.0f;
};

// Each iteration's. The error's modes shrink by factors from 0 (rough) to a (smooth) an iteration;
// Chebyshev's polynomial that is small on all of [0, a_N], with a_N so that it is 1/20 there, is the best
// that N iterations can do. Modes beyond a_N, of bodies so stiff that N iterations do not reach across them,
// converge over several substeps.
std::vector<Relaxation> relaxations(std::uint32_t iterations);

// The square root of the largest K H^2 / m whose modes N iterations reduce to 1/20.
double resolved_stiffness(std::uint32_t iterations);

}  // namespace fascicle::model
