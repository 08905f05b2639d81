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

// W_r of each vertex, trace 1: the mean of u u^T over the directions u in which stress is transmitted there.
// Inside, that is all directions, I/3. A free surface transmits none across itself: there W_r is (I - N)/2,
// with N the area-weighted mean of n n^T over the triangles at the vertex. Flesh under sliding layers
// (`slides`, ties.h) also has a surface there. `state` and the model's tetrahedra describe the body.
std::vector<Symmetric> stress_directions(const RestState& state, const model::Model& model,
                                         const std::string& source, const std::vector<char>& slides = {});

// k_r / E_r = V_r C_r of each region, 1/(s^2 Pa), with V_r the volume that belongs to vertex r and
//   C_r = tr(W_r S_r^-1),   S_r = sum m_i r_i r_i^T.
// Under a stress u u^T a region stretches along u by (V_r/k_r) u.S_r^-1 u. Its energy is (k_r/2) sum m_i |D
// r_i|^2, where D is what remains of the deformation once its rotation is removed; the minimum is at k_r D
// S_r = V_r u u^T. C_r is the mean over the directions. `volume` in m^3, `unit` metres per working unit.
//
// A sheet (`sheets`: its unit normal n, else 0; ties.h) transmits stress only along itself, and its S_r is
// almost nothing across itself. So W_r is P/2, P = I - n n^T, and S_r is P S_r P plus, across the sheet, the
// mean of its two in-plane values.
std::vector<double> stiffness_per_pascal(const OneRings& rings, const RestState& state,
                                         std::span<const Symmetric> directions,
                                         std::span<const double> volume, double unit,
                                         std::span<const Eigen::Vector3d> sheets = {});

// The one-rings of a scene with layers that slide (ties.h). In an implicit scene, vertices that would be left
// with neighbours in a plane, or those of a sheet on a line, keep all of theirs: such regions have no
// stiffness. They are told in a warning.
OneRings sliding_rings(const scene::Scene& scene, const OneRings& rings, std::span<const double> volume,
                       const model::Model& model, const std::vector<char>& slides, Report& report);

// What make_elastic keeps for another scene that differs only in moduli, frequencies and damping: body,
// layers, masses and weights are the same.
struct ElasticMemory {
  std::vector<double> per_pascal;  // stiffness_per_pascal; empty: nothing is kept
  // For each layer whose lowest mode was needed.
  std::map<std::size_t, std::optional<LowestMode>> lowest;
};

// For an implicit scene: fills the model's Young's moduli and stiffnesses, the layers' frequencies and the
// damping for a given ratio, and multiplies the weights by k_r.
//
// A region takes the modulus of its vertex's layer, times the painted factor. If the layer states none, as a
// kinematic one may, the region takes the mass-weighted mean of its vertices that have one. A layer's
// frequency is that of its lowest mode with everything else held still. For it, all regions that reach into
// the layer are as stiff as the layer is without paint.
//
// Throws scene::SceneError for a frequency or a ratio of a layer that nothing holds.
void make_elastic(const scene::Scene& scene, const Layering& layering, const OneRings& rings,
                  const RestState& state, std::span<const double> volume, RegionWeights& weights,
                  model::Model& model, Report& report, ElasticMemory* memory = nullptr);

}  // namespace fascicle::build
