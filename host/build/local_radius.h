// How thick a body is around each of its vertices.
#pragma once

#include <vector>

#include "host/build/body.h"

namespace fascicle::build {

// For each vertex, the radius of the largest ball inside the skin that reaches it, m: about half the
// thickness of the limb, tail or belly it belongs to, whether it lies at the skin or deep inside. `from_skin`
// is each vertex's distance to the skin, m. Balls are centred on vertices. A ball reaches 1.5 times its
// radius, since a limb is not a ball and its edges are farther away than its sides. It reaches only along
// edges between vertices within its reach, so that balls of neighbouring limbs do not count. The least radius
// is half the mean edge at its centre: thinner parts have no vertex inside. A corner that no ball centred
// inside reaches takes the largest radius within two edges.
std::vector<double> local_radii(const mesh::TetMesh& mesh, const std::vector<double>& from_skin);

}  // namespace fascicle::build
