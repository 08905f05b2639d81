// Layers that slide, all of them one skin that does not slide within itself: their free vertices share no
// region with the free vertices of other layers, and ties keep them at their distance from the flesh below,
// which acts across the two and leaves them free along each other.
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

// Whether each vertex is of a layer that slides; empty where no layer does. The model has its tags.
std::vector<char> of_sliding_layers(const scene::Scene& scene, const model::Model& model);

// The triangles that tetrahedra with one corner in such layers turn to it: where the flesh below ends.
std::vector<std::array<std::uint32_t, 3>> triangles_below(const model::Model& model,
                                                          const std::vector<char>& slides);

// The one-rings without the pairs of a free vertex of such a layer and a free one of another. Kinematic
// vertices keep theirs: there skin is attached.
OneRings without_sliding_pairs(const OneRings& rings, const model::Model& model,
                               const std::vector<char>& slides);

// The unit normals of the regions that are sheets, those of free vertices of layers that slide all of whose
// members lie on the surface in such layers; 0 of all others. By the area of the surface's triangles within
// these layers. Empty where no layer slides.
std::vector<Eigen::Vector3d> sheet_normals(const OneRings& rings, const RestState& state,
                                           const model::Model& model, const std::vector<char>& slides,
                                           const std::string& source);

// What a tie bears of a substep. The sum of all ties moves no vertex by more than this share of what is
// wrong.
inline constexpr double tie_share = 0.5;

// Ties each free vertex s of a layer that slides to the plane of the triangle below that is nearest to it at
// rest (shaders/kernel/tie.inc). With w the inverse masses, 0 of kinematic vertices, b_j the foot's
// coordinates in the triangle, wherever s slides, and n_j the number of ties at a corner,
//   k = tie_share / (w_s + sum_j n_j b_j^2 w_j):
// each tie has its part of a corner's mass, so that their steps, taken at once, do not add up to more than
// tie_share. Ties that are too low to tell above from below are left out, with a warning.
//
// Throws scene::SceneError for a layer with vertices none of which lies on free flesh of another. Warns of
// parts of it that nothing holds along that.
void write_ties(const scene::Scene& scene, model::Model& model, Report& report);

}  // namespace fascicle::build
