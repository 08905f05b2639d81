// Stiffness in physical units, for the implicit integrator: from Young's modulus or a frequency to K_i.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/build/layers.h"
#include "host/build/lowest_mode.h"
#include "host/build/one_ring.h"
#include "host/build/weights.h"
#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::build {

// The six entries xx yy zz xy xz yz of a symmetric matrix.
using Symmetric = std::array<double, 6>;

// W_r of each vertex, trace 1: the mean of u u^T over the directions u in which stress is passed on there.
// Inside all do, I/3. Nothing is passed on through a free surface: there (I - N)/2, N the mean of n n^T by
// area over the triangles at the vertex. Flesh under layers that slide (`slides`, ties.h) has a surface there
// too. `state` and the model's tetrahedra are the body.
std::vector<Symmetric> stress_directions(const RestState& state, const model::Model& model,
                                         const std::string& source, const std::vector<char>& slides = {});

// k_r / E_r = V_r C_r of each region, 1/(s^2 Pa): V_r the volume that belongs to vertex r and
//   C_r = tr(W_r S_r^-1),   S_r = sum m_i r_i r_i^T.
// Under a stress u u^T a region stretches along u by (V_r/k_r) u.S_r^-1 u: its energy (k_r/2) sum m_i |D
// r_i|^2, D what is left of the deformation when it is turned back, has its least where k_r D S_r = V_r u
// u^T. C_r is the mean over the directions. `volume` in m^3, `unit` metres per working unit.
//
// A sheet (`sheets`: its unit normal n, else 0; ties.h) passes stress on along itself only, and across itself
// its S_r is next to nothing: W_r is P/2, P = I - n n^T, and S_r is P S_r P with the mean of its two sizes
// across.
std::vector<double> stiffness_per_pascal(const OneRings& rings, const RestState& state,
                                         std::span<const Symmetric> directions,
                                         std::span<const double> volume, double unit,
                                         std::span<const Eigen::Vector3d> sheets = {});

// What make_elastic leaves for another scene that differs in its moduli, frequencies and damping alone: body,
// layers, masses and weights are the same.
struct ElasticMemory {
  std::vector<double> per_pascal;  // stiffness_per_pascal; empty: nothing is kept
  // Of each layer whose lowest mode was asked for.
  std::map<std::size_t, std::optional<LowestMode>> lowest;
};

// Of an implicit scene: fills the model's Young's moduli and stiffnesses, the layers' frequencies and the
// damping that a ratio asks for, and multiplies the weights by k_r.
//
// A region takes the modulus of its vertex's layer, times what is painted there. Where that states none, as a
// kinematic one may, it takes the mean, by mass, of its vertices that have one. A layer's frequency is that
// of its lowest mode with everything else held still, all regions that reach into the layer being as stiff as
// the layer is where nothing is painted.
//
// Throws scene::SceneError for a frequency or a ratio of a layer that nothing holds.
void make_elastic(const scene::Scene& scene, const Layering& layering, const OneRings& rings,
                  const RestState& state, std::span<const double> volume, RegionWeights& weights,
                  model::Model& model, Report& report, ElasticMemory* memory = nullptr);

}  // namespace fascicle::build
