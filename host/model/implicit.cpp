#include "host/model/implicit.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace fascicle::model {

namespace {

// The effective step H used for y and a, for a share t of BDF2.
double step_of(double h, double t) {
  return 2.0 * h / (2.0 + t);
}

// Neither factor of a vertex may bring denormal numbers into a product that is not snapped to zero.
float at_least_least(double x) {
  const float factor = static_cast<float>(x);
  return factor < least_factor ? least_factor : factor;
}

// The x > 1 at which the Chebyshev polynomial of this degree reaches `reduction`, by bisection: rho = 1/x.
double beyond_band(std::uint32_t degree) {
  constexpr double reduction = 20.0;
  const auto chebyshev = [&](double x) {
    double before = 1.0, now = x;
    for (std::uint32_t k = 1; k < degree && now < reduction; ++k) {
      const double next = 2.0 * x * now - before;
      before = now;
      now = next;
    }
    return now;
  };
  double low = 1.0, high = reduction;
  for (int k = 0; k < 60; ++k) {
    const double middle = (low + high) / 2.0;
    (chebyshev(middle) < reduction ? low : high) = middle;
  }
  return high;
}

}  // namespace

// A mode overshoots to about -G/2 of its error (host/build/volume.h).
double volume_overshoot(const Model& model) {
  float gain = 0.0f;
  for (const float g : model.volume_gain) gain = std::max(gain, g);
  return static_cast<double>(gain) / 2.0;
}

double second_order_share(double viscosity, double h) {
  return std::max(0.0, 1.0 - viscosity / h);
}

shader::ImplicitStep implicit_step(const Model& model, const ImplicitTables& tables, bool with_history) {
  const double t = with_history ? tables.second_order : 0.0;
  shader::ImplicitStep step{};
  step.step = static_cast<float>(step_of(tables.h, t));
  step.history = as_factor(t / (2.0 + t));
  step.skin_history = as_factor(t / 2.0);
  step.settled = as_factor(t / (2.0 + 2.0 * t));
  step.start = static_cast<float>(1.0 - t / 2.0);
  step.inverse_step = static_cast<float>((1.0 + t / 2.0) / tables.h);
  step.extrapolated = with_history ? static_cast<float>(tables.extrapolated) : 0.0f;
  step.omega = 1.0f;
  step.gain = 1.0f;
  step.first_response = with_history ? model.vertex_count : 0;
  step.limit_count = static_cast<std::uint32_t>(model.limit.size());
  return step;
}

ImplicitTables implicit_tables(const Model& model, const SolverOptions& options, double h) {
  ImplicitTables tables;
  tables.h = h;
  tables.second_order = second_order_share(options.viscosity, h);
  tables.responses.reserve(2 * std::size_t{model.vertex_count});
  for (const bool with_history : {false, true}) {
    const double H = step_of(h, with_history ? tables.second_order : 0.0);
    double stiffest = 0.0;
    for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
      const double damped = 1.0 + model.layers[model.layer_of(i)].damping * H;
      const double pull = model.stiffness[i] * (H * H);
      tables.responses.push_back({as_factor(pull / (damped + pull)), at_least_least(damped / (damped + pull)),
                                  at_least_least(1.0 / damped), as_factor((damped - 1.0) / damped)});
      if (!model.is_kinematic(i)) stiffest = std::max(stiffest, pull / (damped + pull));
    }
    const double overshoot = volume_overshoot(model);
    tables.relaxations[with_history ? 1 : 0] = relaxations(options.iterations, stiffest, overshoot);
    if (with_history) tables.extrapolated = extrapolated_share(options.iterations, stiffest);
  }
  return tables;
}

double extrapolated_share(std::uint32_t iterations, double stiffest) {
  const double resolved = resolved_stiffness(iterations) * resolved_stiffness(iterations);
  return std::min(1.0, resolved * (1.0 - stiffest) / stiffest);
}

std::vector<Relaxation> relaxations(std::uint32_t iterations, double stiffest, double overshoot) {
  const std::uint32_t over_relaxed = iterations - 1;
  const double share = 1.0 / (1.0 + stiffest * overshoot);
  const double slowest = 1.0 - share * (1.0 - stiffest);
  const double rho = std::min(1.0 / beyond_band(over_relaxed), slowest / (2.0 - slowest));
  std::vector<Relaxation> all;
  double omega = 1.0;
  for (std::uint32_t k = 0; k < over_relaxed; ++k) {
    if (k == 1) omega = 2.0 / (2.0 - rho * rho);
    if (k > 1) omega = 4.0 / (4.0 - rho * rho * omega);
    all.push_back({static_cast<float>(omega), static_cast<float>(share * (1.0 + rho))});
  }
  all.push_back({1.0f, static_cast<float>(share)});
  return all;
}

// The band [0, a_N] is mapped to [-rho, rho]: a_N = 2 rho/(1 + rho), and a = K H^2/(m + K H^2).
double resolved_stiffness(std::uint32_t iterations) {
  if (iterations < 2) return 0.0;
  const double x = beyond_band(iterations - 1);
  return std::sqrt(2.0 / (x - 1.0));
}

// Runs the recurrence of relaxations() on one mode that shrinks by a = S/(1 + S) per pass.
double residual_share(std::uint32_t iterations, double stiffness, double overshoot) {
  const double a = stiffness / (1.0 + stiffness);
  double before = 1.0, now = 1.0;
  for (const Relaxation& pass : relaxations(iterations, a, overshoot)) {
    const double next = before + double{pass.omega} * (double{pass.gain} * (a - 1.0) * now + now - before);
    before = std::exchange(now, next);
  }
  return std::abs(now);
}

}  // namespace fascicle::model
