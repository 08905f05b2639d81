// Moves the boundary of a cage outward until it holds all of the skin.
#pragma once

#include <cstdint>
#include <vector>

#include "host/build/cut.h"

namespace fascicle::build {

// Where the skin's vertices are in the cage.
struct Hold {
  std::vector<std::uint32_t> home;  // as in BodyMesh
  std::vector<double> coordinate;   // the least barycentric one of each there; negative: it sticks out
  double least = 0.0;               // of all
};

// A cage's boundary cuts off what bulges between its vertices, and thin parts. Faces are moved out over each
// vertex of the skin that lies outside, at most `farthest` (m) a vertex; no tetrahedron loses more than
// nineteen twentieths of its volume by that. Then the vertices inside are smoothed, but for the `fixed` ones
// (one flag a vertex of the cage).
Hold hold_skin(CutMesh& cage, const mesh::SurfaceMesh& skin, double farthest, const std::vector<char>& fixed);

}  // namespace fascicle::build
