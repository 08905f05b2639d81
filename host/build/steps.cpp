#include "host/build/steps.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "host/base/text.h"
#include "host/build/message.h"
#include "host/model/implicit.h"

namespace fascicle::build {

namespace {

constexpr double radians_a_turn = 2.0 * std::numbers::pi;
constexpr const char* stated = "the value of solver.substeps";
// For a scene that states its substeps. High, so that even long substeps get the iterations they need.
constexpr std::uint32_t most_iterations_of_stated_substeps = 100;
constexpr std::uint32_t most_substeps = 1000;

// A body of length L, mean edge l and alpha 1 sags by about 0.9 g h^2 L / l^2 of its length (measured on
// bars), because alpha is a stiffness per substep. Flesh hangs on bones, so the share below only ranks
// bodies. It gives a heavy man, a muscular man and a fox of 20,000 vertices 18, 23 and 13 substeps at 60 fps;
// with these, their jumps and the fox's gallop invert hardly more tetrahedra than skinning does (see
// docs/design/crushed-flesh.md).
constexpr double explicit_stretch = 0.023;
constexpr double earth_gravity = 9.81;
// Fewer do not hold flesh, whatever alpha.
constexpr double least_explicit_substeps = 4.0;

double explicit_substeps(const scene::Scene& scene, const model::Model& model) {
  double edges = 0.0;
  std::size_t count = 0;
  std::vector<char> has_flesh(std::max<std::size_t>(scene.characters.size(), 1), 0);
  double length = 0.0;
  const std::vector<double> lengths = model::extents(model, scene::first_joints(scene));
  for (const std::size_t k : scene::characters_with_flesh(scene)) {
    has_flesh[k] = 1;
    length = std::max(length, lengths.at(k));
  }
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    if (!scene.characters.empty() &&
        has_flesh[scene::character_of_joint(scene, model.skin_joint[model.skin_offset[i]])] == 0)
      continue;
    count += model.ring_offset[i + 1] - model.ring_offset[i];
    for (std::uint32_t k = model.ring_offset[i]; k < model.ring_offset[i + 1]; ++k) {
      double squared = 0.0;
      for (std::size_t c = 0; c < 3; ++c) {
        const double d = double{model.rest[3 * std::size_t{model.ring[k]} + c]} -
                         double{model.rest[3 * std::size_t{i} + c]};
        squared += d * d;
      }
      edges += std::sqrt(squared);
    }
  }
  const double mean_edge = edges / static_cast<double>(count) * model.unit;
  const double needed =
      std::ceil(std::sqrt(0.9 * earth_gravity * length / explicit_stretch) / (mean_edge * scene.fps));
  return std::max(needed, least_explicit_substeps);
}

Steps choose_explicit_steps(const scene::Scene& scene, const model::Model& model, Report& report) {
  const double needed = explicit_substeps(scene, model);
  bool is_soft = false;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) is_soft = is_soft || !model.is_kinematic(i);
  if (is_soft && needed > most_explicit_auto_substeps)
    warn(report, "solver.substeps: alpha needs " +
                     std::to_string(static_cast<std::uint64_t>(std::min(needed, 1e15))) +
                     " substeps to mean the same at every frame rate and spacing; \"auto\" uses " +
                     std::to_string(most_explicit_auto_substeps) +
                     " at most, so flesh will be softer; raise fps, or use a coarser mesh");
  return {.substeps = static_cast<std::uint32_t>(std::min(needed, double{most_explicit_auto_substeps})),
          .reason = "with these, alpha means the same at every frame rate and spacing"};
}

// The stiffness that the iterations see: mass-weighted mean of K/m over each layer's free vertices; 0 if
// there are none.
std::vector<double> stiffness_of_layers(const model::Model& model) {
  std::vector<double> pull(model.layers.size(), 0.0), mass(model.layers.size(), 0.0);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    if (model.is_kinematic(i)) continue;
    pull[model.layer_of(i)] += model.stiffness[i] * model.mass[i];
    mass[model.layer_of(i)] += model.mass[i];
  }
  for (std::size_t l = 0; l < pull.size(); ++l) pull[l] = mass[l] > 0.0 ? pull[l] / mass[l] : 0.0;
  return pull;
}

double stiffest_vertex(const model::Model& model) {
  double largest = 0.0;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    if (!model.is_kinematic(i)) largest = std::max(largest, model.stiffness[i]);
  return largest;
}

// The largest of the layers' values, and its layer; the first layer if none is above 0.
struct Largest {
  double value = 0.0;
  std::size_t layer = 0;
};
Largest largest_of(const std::vector<double>& values) {
  Largest largest;
  for (std::size_t l = 0; l < values.size(); ++l)
    if (values[l] > largest.value) largest = {values[l], l};
  return largest;
}

// H is 2h/(2 + t), with t the share of BDF2 that the viscosity leaves.
double stiffness_of_step(double k_over_m, double substeps_per_second, double viscosity) {
  const double h = 1.0 / substeps_per_second;
  const double H = 2.0 * h / (2.0 + model::second_order_share(viscosity, h));
  return k_over_m * H * H;
}

// The fewest iterations that resolve the stiffness; more if a volume term takes its share of each.
std::uint32_t iterations_for(double stiffness, double overshoot, std::uint32_t most) {
  std::uint32_t n = 2;
  while (n < most && model::resolved_stiffness(n) * model::resolved_stiffness(n) < stiffness) ++n;
  while (n < most && model::residual_share(n, stiffness, overshoot) > model::resolved_residual) ++n;
  return n;
}

std::string rounded_up(double x) {
  return std::to_string(static_cast<std::uint64_t>(std::min(std::ceil(x), 1e15)));
}

// Without the iterations' residual.
StepError error_of(double frequency, double substeps_per_second) {
  const double phase = radians_a_turn * frequency / substeps_per_second;
  return {.slower = phase * phase / 3.0,
          .lost = 1.0 - std::exp(-radians_a_turn * phase * phase * phase / 4.0)};
}

Steps choose_implicit_steps(const scene::Scene& scene, const model::Model& model, Report& report) {
  const scene::SolverSettings& solver = scene.solver;
  std::vector<double> frequencies;
  const std::vector<double> stiffnesses = stiffness_of_layers(model);
  for (std::size_t l = 0; l < model.layers.size(); ++l)
    frequencies.push_back(stiffnesses[l] > 0.0 ? model.layers[l].frequency : 0.0);
  const Largest swing = largest_of(frequencies), stiff = largest_of(stiffnesses);
  const auto of_layer = [&](const Largest& largest) { return "layers." + model.layers[largest.layer].name; };

  Steps steps{.substeps = solver.substeps, .reason = stated};
  if (solver.auto_substeps) {
    // A rate that exceeds a whole number only by rounding needs no further substep.
    constexpr double rounding = 1e-6;
    const double by_quality =
        std::clamp(steps_per_second(solver.quality) / scene.fps - rounding, 1.0, double{most_substeps});
    const double by_mode = model.has_skeleton()
                               ? 0.0
                               : radians_a_turn * swing.value / (longest_phase(solver.quality) * scene.fps);
    const double reached = model::resolved_stiffness(solver.iterations.value_or(most_auto_iterations));
    const double by_stiffness = 2.0 / 3.0 * std::sqrt(stiff.value) / (reached * scene.fps);
    steps.reason = std::string("quality \"") + name_of(solver.quality) + '"';
    if (by_mode > by_quality) steps.reason = "the lowest mode of " + of_layer(swing);
    if (by_stiffness > std::max(by_quality, by_mode)) steps.reason = "the stiffness of " + of_layer(stiff);
    const double by_flesh = std::ceil(std::max(by_mode, by_stiffness));
    if (by_flesh > most_auto_substeps)
      warn(report, of_layer(by_stiffness > by_mode ? stiff : swing) + ": is so stiff that it would need " +
                       rounded_up(by_flesh) + " substeps; \"auto\" uses " +
                       std::to_string(most_auto_substeps) +
                       " at most. It will come to rest in the right place, but move more slowly; set "
                       "solver.substeps, or make it softer");
    steps.substeps = static_cast<std::uint32_t>(
        std::ceil(std::max(by_quality, std::min(by_flesh, double{most_auto_substeps}))));
  }
  const double a_second = steps.substeps * scene.fps;
  // A body without a skeleton loses 6 % more of its swing if iterations resolve only the mean: then they
  // start from less than the last substep's acceleration (model::extrapolated_share).
  const double resolved = model.has_skeleton() ? stiff.value : stiffest_vertex(model);
  // What more iterations would add to a character's viscous step does not show (docs/design/integrators.md).
  const double viscosity = model.has_skeleton() ? 0.0 : solver.viscosity;
  const double overshoot = model::volume_overshoot(model);
  const std::uint32_t enough =
      iterations_for(stiffness_of_step(resolved, a_second, viscosity), overshoot,
                     solver.auto_substeps ? most_auto_iterations : most_iterations_of_stated_substeps);
  steps.iterations = solver.iterations.value_or(enough);
  steps.error = error_of(swing.value, a_second);
  const auto residual = [&](double of_viscosity) {
    return model::residual_share(steps.iterations, stiffness_of_step(stiff.value, a_second, of_viscosity),
                                 overshoot);
  };
  steps.error.residual = residual(solver.viscosity);
  const double longest = 1.0 / a_second;
  if (solver.has_stated_viscosity && solver.viscosity > longest * (1.0 + 1e-6))
    warn(report, "solver.viscosity: " + base::short_text(1e3 * solver.viscosity) +
                     " ms is longer than a substep, so only the " + base::short_text(1e3 * longest) +
                     " ms of a substep act; use damping for the rest, or fewer substeps");
  // For auto substeps a warning has already been given.
  if (!solver.auto_substeps && residual(viscosity) > model::resolved_residual * (1.0 + 1e-9))
    warn(report, "solver.iterations: " + std::to_string(steps.iterations) + " leave " +
                     base::percent_text(steps.error.residual) + " of a substep's change in " +
                     of_layer(stiff) + " undone, so it lags and yields more than it should; " +
                     (steps.iterations < enough ? "\"auto\" uses " + std::to_string(enough)
                                                : std::string("use more substeps, or \"auto\"")));
  if (solver.auto_substeps || stiff.value == 0.0) return steps;
  const double least = steps_per_second(scene::Quality::draft);
  if (model.has_skeleton() && a_second < least * (1.0 - 1e-6))
    warn(report, "solver.substeps: " + std::to_string(solver.substeps) + " a frame are " +
                     base::short_text(a_second) + " a second, too few for flesh not to lag; use " +
                     rounded_up(least / scene.fps) + ", or \"auto\"");
  if (!model.has_skeleton() && radians_a_turn * swing.value > longest_phase(scene::Quality::draft) * a_second)
    warn(report,
         "solver.substeps: with " + std::to_string(solver.substeps) + " the lowest mode of " +
             of_layer(swing) + ", " + base::short_text(swing.value) + " Hz, swings " +
             base::percent_text(steps.error.slower) + " slower and loses " +
             base::percent_text(steps.error.lost) + " of its swing in each period; use " +
             rounded_up(radians_a_turn * swing.value / (longest_phase(scene::Quality::draft) * scene.fps)) +
             ", or \"auto\"");
  return steps;
}

}  // namespace

double steps_per_second(scene::Quality quality) {
  // The time step's error on a heavy man's jump is 1.7, 0.6 and less than 0.1 mm
  // (docs/design/integrators.md).
  switch (quality) {
    case scene::Quality::draft:
      return 240.0;
    case scene::Quality::normal:
      return 480.0;
    case scene::Quality::final:
      return 1440.0;
  }
  return 480.0;
}

double longest_phase(scene::Quality quality) {
  // The frequency is off by 0.9, 0.2 and 0.02 %.
  return 0.16 * steps_per_second(scene::Quality::draft) / steps_per_second(quality);
}

bool steps_need_lowest_modes(const scene::SolverSettings& solver, const model::Model& model) {
  return solver.auto_substeps && !model.has_skeleton();
}

Steps choose_steps(const scene::Scene& scene, const model::Model& model, Report& report) {
  if (model.is_implicit()) return choose_implicit_steps(scene, model, report);
  if (scene.solver.auto_substeps) return choose_explicit_steps(scene, model, report);
  return {.substeps = scene.solver.substeps, .reason = stated};
}

}  // namespace fascicle::build
