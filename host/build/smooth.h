// Moves vertices inside a tetrahedral mesh so that no tetrahedron stays flat.
#pragma once

#include <cstdint>
#include <vector>

#include "host/scene/scene.h"

namespace fascicle::build {

// How close a tetrahedron is to regular: 1 for a regular one, 0 for a flat one, 0.13 for one with a fifth of
// the regular one's height. It is the cube of the mean ratio, 15552 V^2 / (sum of the squares of the edges)^3
// (Liu and Joe, "On the shape of tetrahedra from bisection", Math. Comp. 63, 1994).
double shape_quality(const mesh::TetMesh& mesh, const std::array<std::uint32_t, 4>& tetrahedron);

// Tetrahedra must have positive volume, and keep it. Vertices of the boundary and `fixed` ones (one flag per
// vertex) do not move. Each other vertex moves, in turn, to where the sum of 1 / quality over its tetrahedra
// is least; the worst of them dominates that sum.
void smooth_inside(mesh::TetMesh& mesh, const std::vector<char>& fixed);

}  // namespace fascicle::build
