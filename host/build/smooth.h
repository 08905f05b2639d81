// Moves vertices inside a tetrahedral mesh so that no tetrahedron stays flat.
#pragma once

#include <cstdint>
#include <vector>

#include "host/scene/scene.h"

namespace fascicle::build {

// How far a tetrahedron is from regular: 1 there, 0 where it is flat, 0.13 for one of a fifth of the regular
// one's height. It is the cube of the mean ratio, 15552 V^2 / (sum of the squares of the edges)^3 (Liu and
// Joe, "On the shape of tetrahedra from bisection", Math. Comp. 63, 1994).
double shape_quality(const mesh::TetMesh& mesh, const std::array<std::uint32_t, 4>& tetrahedron);

// Tetrahedra of positive volume, and stay so. Vertices of the boundary and those that are `fixed` (one flag a
// vertex) stay where they are; each other one is moved, in turn, to where the sum of 1 / quality over its
// tetrahedra is least, which the worst of them governs.
void smooth_inside(mesh::TetMesh& mesh, const std::vector<char>& fixed);

}  // namespace fascicle::build
