#include "host/build/stiffness.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "host/build/lowest_mode.h"
#include "host/build/message.h"
#include "host/model/implicit.h"

namespace fascicle::build {

namespace {

using Eigen::Vector3d;

constexpr double two_pi = 6.283185307179586;
// By which 2 pi f h BDF2's own errors stay small: the period is off by (2 pi f h)^2/3, 0.9 %, and the damping
// ratio by (2 pi f h)^3/4, 0.001.
constexpr double longest_phase = 0.16;

template <class Visit>
void for_each_of_region(const OneRings& rings, std::size_t r, Visit visit) {
  visit(r);
  for (const std::uint32_t i : rings[r]) visit(std::size_t{i});
}

// The six entries xx yy zz xy xz yz of S_r.
std::array<double, 6> second_moment(const OneRings& rings, const RestState& state, std::size_t r) {
  const Vector3d q0 = rest_at(state, r);
  Vector3d first = Vector3d::Zero();
  double mass = 0.0;
  for_each_of_region(rings, r, [&](std::size_t i) {
    first += state.mass[i] * (rest_at(state, i) - q0);
    mass += state.mass[i];
  });
  const Vector3d centre = first / mass;
  std::array<double, 6> s{};
  for_each_of_region(rings, r, [&](std::size_t i) {
    const Vector3d p = rest_at(state, i) - q0 - centre;
    const double m = state.mass[i];
    const std::array<double, 6> products{p[0] * p[0], p[1] * p[1], p[2] * p[2],
                                         p[0] * p[1], p[0] * p[2], p[1] * p[2]};
    for (std::size_t c = 0; c < 6; ++c) s[c] += m * products[c];
  });
  return s;
}

// C_r by the invariants of S, so that no eigenvalues are needed: sum 1/s_a = I2/I3, and the sums s_a + s_b
// are I1 - s_c, whose products give sum 1/(s_a + s_b) = (I1^2 + I2)/(I1 I2 - I3).
double mean_compliance(const std::array<double, 6>& s) {
  const auto [xx, yy, zz, xy, xz, yz] = s;
  const double one = xx + yy + zz;
  const double two = (xx * yy - xy * xy) + (xx * zz - xz * xz) + (yy * zz - yz * yz);
  const double three = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
  return two / (5.0 * three) + 4.0 / 15.0 * (one * one + two) / (one * two - three);
}

// Pa, or nothing where the layer states none; a layer that states a frequency has it from its lowest mode.
using LayerModuli = std::vector<std::optional<double>>;

std::vector<double> moduli_of_regions(const Layering& layering, const LayerModuli& of_layer,
                                      const OneRings& rings, const RestState& state) {
  double sum = 0.0, masses = 0.0;
  for (std::size_t i = 0; i < rings.size(); ++i)
    if (const auto& E = of_layer[layering.layer[i]]) {
      sum += state.mass[i] * *E;
      masses += state.mass[i];
    }
  // Of regions that hold no vertex with a modulus: nothing that moves sees them.
  const double elsewhere = masses > 0.0 ? sum / masses : 1.0;
  std::vector<double> moduli(rings.size());
  for (std::size_t r = 0; r < rings.size(); ++r) {
    if (const auto& E = of_layer[layering.layer[r]]) {
      moduli[r] = *E;
      continue;
    }
    double near = 0.0, mass = 0.0;
    for (const std::uint32_t i : rings[r])
      if (const auto& E = of_layer[layering.layer[i]]) {
        near += state.mass[i] * *E;
        mass += state.mass[i];
      }
    moduli[r] = mass > 0.0 ? near / mass : elsewhere;
  }
  return moduli;
}

// The square of a layer's lowest circular frequency, 1/s^2, at 1 Pa.
double stiffness_of_lowest_mode(const scene::Scene& scene, std::size_t l, const Layering& layering,
                                const ElasticBody& body, Report& report) {
  std::vector<char> is_free(layering.layer.size());
  for (std::size_t i = 0; i < is_free.size(); ++i)
    is_free[i] = layering.layer[i] == l && layering.kinematic[i] == 0;
  const std::optional<LowestMode> lowest = lowest_mode(body, is_free);
  if (!lowest)
    fail(scene.source, "layers." + scene.layers[l].name +
                           ": nothing holds it, so its lowest mode has no frequency; pin a part, or state "
                           "youngs_modulus and damping, and substeps as a number");
  if (!lowest->settled)
    warn(report,
         "layers." + scene.layers[l].name +
             ": the search for its lowest mode did not settle, so its frequency may lie lower than it "
             "says; state youngs_modulus, and substeps as a number");
  return lowest->square;
}

bool needs_lowest_mode(const scene::Scene& scene, const scene::Layer& layer) {
  return layer.frequency || layer.damping_ratio || scene.solver.auto_substeps;
}

}  // namespace

std::vector<double> stiffness_per_pascal(const OneRings& rings, const RestState& state,
                                         std::span<const double> volume, double unit) {
  std::vector<double> k(rings.size());
  for (std::size_t r = 0; r < k.size(); ++r)
    k[r] = volume[r] * mean_compliance(second_moment(rings, state, r)) / (unit * unit);
  return k;
}

void make_elastic(const scene::Scene& scene, const Layering& layering, const OneRings& rings,
                  const RestState& state, std::span<const double> volume, RegionWeights& weights,
                  model::Model& model, Report& report) {
  const std::vector<double> per_pascal = stiffness_per_pascal(rings, state, volume, model.unit);
  std::vector<std::uint32_t> flat;
  for (std::uint32_t r = 0; r < rings.size(); ++r)
    if (!(per_pascal[r] > 0.0) || !std::isfinite(per_pascal[r])) flat.push_back(model.source_vertex[r]);
  if (!flat.empty())
    fail(scene.source, "mesh: the tetrahedra around vertex " + list_of(flat) +
                           " lie in a plane, so they have no stiffness; improve the mesh there");

  LayerModuli of_layer(scene.layers.size());
  const ElasticBody body{rings, state, weights, per_pascal};
  for (std::size_t l = 0; l < scene.layers.size(); ++l) {
    const scene::Layer& layer = scene.layers[l];
    of_layer[l] = layer.youngs_modulus;
    bool moves = false;
    for (std::size_t i = 0; i < layering.layer.size(); ++i)
      moves = moves || (layering.layer[i] == l && layering.kinematic[i] == 0);
    if (!moves || !needs_lowest_mode(scene, layer)) continue;
    const double lowest = stiffness_of_lowest_mode(scene, l, layering, body, report);
    if (layer.frequency) of_layer[l] = (two_pi * *layer.frequency) * (two_pi * *layer.frequency) / lowest;
    model.layers[l].frequency = std::sqrt(of_layer[l].value() * lowest) / two_pi;
    if (layer.damping_ratio)
      model.layers[l].damping = 2.0 * *layer.damping_ratio * (two_pi * model.layers[l].frequency);
  }

  model.youngs_modulus = moduli_of_regions(layering, of_layer, rings, state);
  std::vector<double> k = per_pascal;
  for (std::size_t r = 0; r < k.size(); ++r) k[r] *= model.youngs_modulus[r];
  model.stiffness = k;
  for (std::size_t i = 0; i < k.size(); ++i)
    for (const std::uint32_t r : rings[i]) model.stiffness[i] += k[r];
  for (std::size_t r = 0; r < k.size(); ++r) {
    weights.own[r] *= k[r];
    for (std::uint32_t e = rings.offset[r]; e < rings.offset[r + 1]; ++e) weights.taken[e] *= k[r];
  }
  for (std::size_t l = 0; l < report.layers.size(); ++l) report.layers[l].youngs_modulus = of_layer[l];
}

void choose_steps(scene::Scene& scene, const model::Model& model, Report& report) {
  if (!scene.solver.auto_substeps || !model.is_implicit()) return;
  std::vector<double> pull(model.layers.size(), 0.0), mass(model.layers.size(), 0.0);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    if (model.is_kinematic(i)) continue;
    pull[model.layer_of(i)] += model.stiffness[i] * model.mass[i];
    mass[model.layer_of(i)] += model.mass[i];
  }
  const double reached = model::resolved_stiffness(scene.solver.iterations);
  double needed = 1.0;
  std::string stiffest;
  for (std::size_t l = 0; l < model.layers.size(); ++l) {
    if (mass[l] == 0.0) continue;
    const double by_mode = two_pi * model.layers[l].frequency / (longest_phase * scene.fps);
    const double by_stiffness = 2.0 / 3.0 * std::sqrt(pull[l] / mass[l]) / (reached * scene.fps);
    if (std::max(by_mode, by_stiffness) <= needed) continue;
    needed = std::max(by_mode, by_stiffness);
    stiffest = model.layers[l].name;
  }
  needed = std::ceil(needed);
  scene.solver.substeps = static_cast<std::uint32_t>(std::min(needed, double{most_auto_substeps}));
  if (needed > most_auto_substeps)
    warn(
        report,
        "layers." + stiffest + ": is so stiff that it would take " +
            std::to_string(static_cast<std::uint64_t>(std::min(needed, 1e15))) + " substeps of " +
            std::to_string(scene.solver.iterations) + " iterations; \"auto\" takes " +
            std::to_string(most_auto_substeps) +
            " at most, so it will move more slowly than it should, to the same rest; set solver.substeps, or "
            "make it softer");
}

}  // namespace fascicle::build
