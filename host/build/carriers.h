// Carriers: tetrahedra apart from the flesh, on which render vertices ride that must go where skinning has
// them.
//
// For each set of weights among its riders there is one, connected to nothing, that moves by just these
// weights. Blended bones are one affine map of space, so a rider keeps its place to rounding.
#pragma once

#include <utility>
#include <vector>

#include "host/build/body.h"
#include "host/build/weld.h"

namespace fascicle::build {

// The weights of a vertex: joint and weight, ascending.
using WeightRow = std::vector<std::pair<std::uint32_t, double>>;
WeightRow weight_row(const SkinWeights& weights, std::uint32_t vertex);

// Which riders share a carrier: those of the very same weights; or, where that makes more than 3,000
// carriers, those of like weights, which it moves by their mean: the same when rounded to a 64th, or as
// coarsely as it takes, to an eighth at most. Faces and hands have thousands of rows of weights, and a
// carrier has four vertices.
enum class Sharing { exact, alike };

// Seats the render vertices of those welded vertices that `rides` marks. `weights` are those of the welded
// skin; the body must have its render mesh, its holding and at least the first of its weights' offsets.
void seat_on_carriers(const WeldedSurface& welded, const SkinWeights& weights, const std::vector<char>& rides,
                      Sharing sharing, Body& body);

// The welded vertices that follow the skeleton by their own weights (measures.h), and whose render vertices
// ride on flesh that other joints move, by a tenth of their weights or more: a cage joins the tips of
// jaws that are shut. The body must be whole.
std::vector<char> misled_riders(const WeldedSurface& welded, const SkinWeights& weights, const Body& body);

}  // namespace fascicle::build
