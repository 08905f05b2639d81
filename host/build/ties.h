// Sliding layers, which together form a skin that does not slide within itself. Their free vertices share no
// region with free vertices of other layers. Ties keep them at their distance from the flesh below; they act
// across the two and let them slide along each other.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/build/one_ring.h"
#include "host/build/weights.h"
#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::build {

struct Report;

// Whether each vertex belongs to a sliding layer; empty if no layer slides. The model must have its tags.
std::vector<char> of_sliding_layers(const scene::Scene& scene, const model::Model& model);

// The faces that tetrahedra with one corner in such layers turn towards it: where the flesh below ends.
std::vector<std::array<std::uint32_t, 3>> triangles_below(const model::Model& model,
                                                          const std::vector<char>& slides);

// The one-rings without pairs of a free vertex of such a layer and a free vertex of another. Kinematic
// vertices keep their pairs: skin is attached there. So do those in `keeps`, a flag per vertex, if there are
// any.
OneRings without_sliding_pairs(const OneRings& rings, const model::Model& model,
                               const std::vector<char>& slides, const std::vector<char>& keeps = {});

// The unit normals of sheet regions: those of free vertices of sliding layers whose members all lie on the
// surface in such layers; 0 for all others. Area-weighted over the surface's triangles within these layers.
// Empty if no layer slides.
std::vector<Eigen::Vector3d> sheet_normals(const OneRings& rings, const RestState& state,
                                           const model::Model& model, const std::vector<char>& slides,
                                           const std::string& source);

// How much of its error a tie corrects in a substep. The sum of all ties moves no vertex by more than this
// share of the error.
inline constexpr double tie_share = 0.5;

// Ties each free vertex s of a sliding layer to the plane of the triangle below that is nearest to it at rest
// (shaders/kernel/tie.inc). With w the inverse masses (0 for kinematic vertices), b_j the barycentric
// coordinates of the foot of s in the triangle, and n_j the number of ties at a corner,
//   k = tie_share / (w_s + sum_j n_j b_j^2 w_j):
// each tie gets its part of a corner's mass, so that simultaneous corrections do not add up to more than
// tie_share. Ties too low to tell above from below are left out, with a warning.
//
// Throws scene::SceneError for a non-empty layer with no free vertex on free flesh of another layer. Warns of
// parts of sliding layers that reach no pin and no bone.
void write_ties(const scene::Scene& scene, model::Model& model, Report& report);

}  // namespace fascicle::build
