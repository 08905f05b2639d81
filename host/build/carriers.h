// Carriers: tetrahedra separate from the flesh, for render vertices that must move exactly as skinning moves
// them.
//
// There is one carrier for each set of weights among its riders. It is connected to nothing and moves by
// these weights alone. Blended bones are a single affine map of space, so a rider keeps its place to
// rounding.
#pragma once

#include <utility>
#include <vector>

#include "host/build/body.h"
#include "host/build/weld.h"

namespace fascicle::build {

// The weights of a vertex: joint and weight, ascending.
using WeightRow = std::vector<std::pair<std::uint32_t, double>>;
WeightRow weight_row(const SkinWeights& weights, std::uint32_t vertex);

// Riders with exactly the same weights share a carrier; or, if that makes more than 3,000 carriers, those
// with similar weights, whose carrier moves by their mean. Weights are similar if they are equal when rounded
// to a 64th, or more coarsely as needed, down to an eighth. Faces and hands have thousands of rows of
// weights, and a carrier has four vertices. `exact` carriers move by their riders' weights as they are,
// `alike` ones by weights that were divided by their sum; beyond 3,000 carriers all do.
enum class Sharing { exact, alike };

// Places the render vertices of the welded vertices marked in `rides` on carriers. `weights` are those of the
// welded skin. The body must have its render mesh, its holding and at least the first offset of its weights.
void seat_on_carriers(const WeldedSurface& welded, const SkinWeights& weights, const std::vector<char>& rides,
                      Sharing sharing, Body& body);

// The welded vertices that follow the skeleton by their own weights (measures.h), but whose render vertices
// ride on flesh that other joints move by a tenth of its weights or more: a cage joins the tips of closed
// jaws. The body must be complete.
std::vector<char> misled_riders(const WeldedSurface& welded, const SkinWeights& weights, const Body& body);

}  // namespace fascicle::build
