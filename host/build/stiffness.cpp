#include "host/build/stiffness.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "host/build/boundary.h"
#include "host/build/lowest_mode.h"
#include "host/build/message.h"
#include "host/build/steps.h"
#include "host/build/ties.h"

namespace fascicle::build {

namespace {

using Eigen::Vector3d;

constexpr double two_pi = 6.283185307179586;

template <class Visit>
void for_each_of_region(const OneRings& rings, std::size_t r, Visit visit) {
  visit(r);
  for (const std::uint32_t i : rings[r]) visit(std::size_t{i});
}

Symmetric product(const Vector3d& p) {
  return {p[0] * p[0], p[1] * p[1], p[2] * p[2], p[0] * p[1], p[0] * p[2], p[1] * p[2]};
}

void add(double factor, const Symmetric& m, Symmetric& to) {
  for (std::size_t c = 0; c < 6; ++c) to[c] += factor * m[c];
}

// S_r
Symmetric second_moment(const OneRings& rings, const RestState& state, std::size_t r) {
  const Vector3d q0 = rest_at(state, r);
  Vector3d first = Vector3d::Zero();
  double mass = 0.0;
  for_each_of_region(rings, r, [&](std::size_t i) {
    first += state.mass[i] * (rest_at(state, i) - q0);
    mass += state.mass[i];
  });
  const Vector3d centre = first / mass;
  Symmetric s{};
  for_each_of_region(rings, r,
                     [&](std::size_t i) { add(state.mass[i], product(rest_at(state, i) - q0 - centre), s); });
  return s;
}

// tr(W S^-1), by the adjugate of S.
double compliance(const Symmetric& w, const Symmetric& s) {
  const auto [xx, yy, zz, xy, xz, yz] = s;
  const Symmetric adjugate{yy * zz - yz * yz, xx * zz - xz * xz, xx * yy - xy * xy,
                           xz * yz - xy * zz, xy * yz - xz * yy, xy * xz - xx * yz};
  const double determinant = xx * adjugate[0] + xy * adjugate[3] + xz * adjugate[4];
  return (w[0] * adjugate[0] + w[1] * adjugate[1] + w[2] * adjugate[2] +
          2.0 * (w[3] * adjugate[3] + w[4] * adjugate[4] + w[5] * adjugate[5])) /
         determinant;
}

// Whether a compliance C_r is only that of rounding: members in a plane, which differ from it by less than
// three hundred-thousandths of the region's size, or no number at all. Rest positions are floats, which a
// region of a two-hundredth of the body's size has to 1e-5 of its own.
bool is_stiff_by_rounding(double compliance, const Symmetric& s) {
  constexpr double most = 1e9;
  const double stiffness = compliance * (s[0] + s[1] + s[2]);
  return !(stiffness > 0.0 && stiffness < most);
}

// C_r of a sheet of unit normal n, from its S.
double sheet_compliance(const Vector3d& n, const Symmetric& s) {
  const auto [xx, yy, zz, xy, xz, yz] = s;
  const Vector3d sn(xx * n[0] + xy * n[1] + xz * n[2], xy * n[0] + yy * n[1] + yz * n[2],
                    xz * n[0] + yz * n[1] + zz * n[2]);
  const double nsn = n[0] * sn[0] + n[1] * sn[1] + n[2] * sn[2];
  const double across = (xx + yy + zz - nsn) / 2.0;
  const Vector3d both = n + sn;
  Symmetric w{}, flat = s;
  add(0.5, {1.0, 1.0, 1.0, 0.0, 0.0, 0.0}, w);
  add(-0.5, product(n), w);
  // P S P = S - (n (S n)^T + S n n^T) + (n.S n) n n^T, and n a^T + a n^T is (n + a)(n + a)^T - n n^T - a a^T.
  add(-1.0, product(both), flat);
  add(1.0, product(sn), flat);
  add(1.0 + nsn + across, product(n), flat);
  return compliance(w, flat);
}

// Pa, or nothing if the layer states none; if a layer states a frequency, its modulus comes from its lowest
// mode.
using LayerModuli = std::vector<std::optional<double>>;

std::vector<double> moduli_of_regions(const Layering& layering, const LayerModuli& of_layer,
                                      const OneRings& rings, const RestState& state) {
  const auto modulus_at = [&](std::size_t i) {
    std::optional<double> E = of_layer[layering.layer[i]];
    if (E && !layering.stiffer.empty()) *E *= layering.stiffer[i];
    return E;
  };
  double sum = 0.0, masses = 0.0;
  for (std::size_t i = 0; i < rings.size(); ++i)
    if (const auto E = modulus_at(i)) {
      sum += state.mass[i] * *E;
      masses += state.mass[i];
    }
  // For regions without any vertex that has a modulus: they affect nothing that moves.
  const double elsewhere = masses > 0.0 ? sum / masses : 1.0;
  std::vector<double> moduli(rings.size());
  for (std::size_t r = 0; r < rings.size(); ++r) {
    if (const auto E = modulus_at(r)) {
      moduli[r] = *E;
      continue;
    }
    double near = 0.0, mass = 0.0;
    for (const std::uint32_t i : rings[r])
      if (const auto E = modulus_at(i)) {
        near += state.mass[i] * *E;
        mass += state.mass[i];
      }
    moduli[r] = mass > 0.0 ? near / mass : elsewhere;
  }
  return moduli;
}

// The square of a layer's lowest circular frequency, 1/s^2, at 1 Pa. 0 if nothing holds the layer and only
// "auto" needs it, which then uses the stiffness alone.
double stiffness_of_lowest_mode(const scene::Scene& scene, std::size_t l, const Layering& layering,
                                const ElasticBody& body, ElasticMemory& memory, Report& report) {
  if (!memory.lowest.contains(l)) {
    std::vector<char> is_free(layering.layer.size());
    for (std::size_t i = 0; i < is_free.size(); ++i)
      is_free[i] = layering.layer[i] == l && layering.kinematic[i] == 0;
    memory.lowest[l] = lowest_mode(body, is_free);
  }
  const scene::Layer& layer = scene.layers[l];
  const std::optional<LowestMode>& lowest = memory.lowest[l];
  if (!lowest) {
    if (!layer.frequency && !layer.damping_ratio) return 0.0;
    fail(scene.source, "layers." + layer.name +
                           ": nothing holds it, so its lowest mode has no frequency; pin a part, or set "
                           "youngs_modulus and damping");
  }
  if (!lowest->settled)
    warn(report, "layers." + layer.name +
                     ": the search for its lowest mode did not converge, so the layer may be softer than its "
                     "frequency says; set youngs_modulus instead, and substeps as a number");
  return lowest->square;
}

bool needs_lowest_mode(const scene::Scene& scene, const scene::Layer& layer, const model::Model& model) {
  return layer.frequency || layer.damping_ratio || steps_need_lowest_modes(scene.solver, model);
}

}  // namespace

std::vector<Symmetric> stress_directions(const RestState& state, const model::Model& model,
                                         const std::string& source, const std::vector<char>& slides) {
  std::vector<Symmetric> normals(state.mass.size(), Symmetric{});
  std::vector<double> area(state.mass.size(), 0.0);
  std::vector<std::array<std::uint32_t, 3>> free_surface = boundary_triangles(model, source);
  const auto below = triangles_below(model, slides);
  free_surface.insert(free_surface.end(), below.begin(), below.end());
  for (const auto& [a, b, c] : free_surface) {
    const Vector3d p = rest_at(state, b) - rest_at(state, a), q = rest_at(state, c) - rest_at(state, a);
    const Vector3d n(p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]);
    const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (!(length > 0.0)) continue;
    for (const std::uint32_t v : {a, b, c}) {
      add(1.0 / length, product(n), normals[v]);
      area[v] += length;
    }
  }
  constexpr Symmetric identity{1.0, 1.0, 1.0, 0.0, 0.0, 0.0};
  std::vector<Symmetric> directions(state.mass.size(), Symmetric{});
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const bool inside = !(area[i] > 0.0);
    add(inside ? 1.0 / 3.0 : 0.5, identity, directions[i]);
    if (!inside) add(-0.5 / area[i], normals[i], directions[i]);
  }
  return directions;
}

std::vector<double> stiffness_per_pascal(const OneRings& rings, const RestState& state,
                                         std::span<const Symmetric> directions,
                                         std::span<const double> volume, double unit,
                                         std::span<const Vector3d> sheets) {
  std::vector<double> k(rings.size());
  for (std::size_t r = 0; r < k.size(); ++r) {
    const Symmetric s = second_moment(rings, state, r);
    const bool is_sheet = !sheets.empty() && !sheets[r].isZero(0.0);
    const double c = is_sheet ? sheet_compliance(sheets[r], s) : compliance(directions[r], s);
    k[r] = volume[r] * c / (unit * unit);
  }
  return k;
}

OneRings sliding_rings(const scene::Scene& scene, const OneRings& rings, std::span<const double> volume,
                       const model::Model& model, const std::vector<char>& slides, Report& report) {
  OneRings cut = without_sliding_pairs(rings, model, slides);
  if (scene.solver.integrator != scene::Integrator::implicit_step) return cut;
  const RestState state{model.rest, model.mass, model.fibre, model.beta};
  const std::vector<Symmetric> directions = stress_directions(state, model, scene.source, slides);
  std::vector<char> keeps(rings.size(), 0);
  std::vector<std::uint32_t> kept;
  for (;;) {
    const std::vector<Vector3d> sheets = sheet_normals(cut, state, model, slides, scene.source);
    const std::vector<double> per_pascal =
        stiffness_per_pascal(cut, state, directions, volume, model.unit, sheets);
    const std::size_t before = kept.size();
    for (std::uint32_t r = 0; r < rings.size(); ++r) {
      if (keeps[r] != 0 || cut.degree(r) == rings.degree(r)) continue;
      if (is_stiff_by_rounding(per_pascal[r] / volume[r] * model.unit * model.unit,
                               second_moment(cut, state, r))) {
        keeps[r] = 1;
        kept.push_back(model.source_vertex[r]);
      }
    }
    if (kept.size() == before) break;
    cut = without_sliding_pairs(rings, model, slides, keeps);
  }
  std::sort(kept.begin(), kept.end());
  if (!kept.empty())
    warn_of_flesh(report,
                  counted(kept.size(), "vertex does", "vertices do") +
                      " not slide, because too few neighbours in its own layer would be left to give it "
                      "stiffness (vertex " +
                      list_of(kept) + ")",
                  kept);
  return cut;
}

void make_elastic(const scene::Scene& scene, const Layering& layering, const OneRings& rings,
                  const RestState& state, std::span<const double> volume, RegionWeights& weights,
                  model::Model& model, Report& report, ElasticMemory* memory) {
  ElasticMemory own;
  ElasticMemory& kept = memory != nullptr ? *memory : own;
  if (kept.per_pascal.empty()) {
    const std::vector<char> slides = of_sliding_layers(scene, model);
    kept.per_pascal =
        stiffness_per_pascal(rings, state, stress_directions(state, model, scene.source, slides), volume,
                             model.unit, sheet_normals(rings, state, model, slides, scene.source));
  }
  const std::vector<double>& per_pascal = kept.per_pascal;
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
    if (!moves || !needs_lowest_mode(scene, layer, model)) continue;
    const double lowest = stiffness_of_lowest_mode(scene, l, layering, body, kept, report);
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

}  // namespace fascicle::build
