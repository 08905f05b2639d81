// How thick a body is around each of its vertices.
#pragma once

#include <vector>

#include "host/build/body.h"

namespace fascicle::build {

// Of each vertex, the radius of the largest ball inside the skin that reaches it, m: about half the thickness
// of the limb, the tail or the belly it belongs to, whether it lies at the skin or deep inside. `from_skin`
// has the distance of each vertex to the skin, m. Balls are centred on vertices. One reaches half as far
// again as its radius, since a limb is no ball and its edges lie further off than its sides. It reaches only
// along edges between vertices in its reach, so that a neighbouring limb's does not count. The least radius
// is half the mean edge at its centre: thinner parts have no vertex inside. A corner that no ball with its
// centre inside reaches has the largest radius within two edges.
std::vector<double> local_radii(const mesh::TetMesh& mesh, const std::vector<double>& from_skin);

}  // namespace fascicle::build
