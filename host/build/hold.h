// Moves the boundary of a cage outward until it contains all of the skin.
#pragma once

#include <cstdint>
#include <vector>

#include "host/build/cut.h"

namespace fascicle::build {

// Where the skin's vertices are in the cage.
struct Hold {
  std::vector<std::uint32_t> home;  // as in BodyMesh
  std::vector<double> coordinate;   // each one's least barycentric coordinate there; negative: it sticks out
  double least = 0.0;               // over all vertices
};

// A cage's boundary cuts off bulges between its vertices, and thin parts. Moves faces out over each skin
// vertex that lies outside, by at most `farthest` (m) per vertex. No tetrahedron loses more than nineteen
// twentieths of its volume. Then smooths the vertices inside, except the `fixed` ones (one flag per vertex of
// the cage).
Hold hold_skin(CutMesh& cage, const mesh::SurfaceMesh& skin, double farthest, const std::vector<char>& fixed);

}  // namespace fascicle::build
