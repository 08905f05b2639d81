// What a tetrahedral mesh must be before anything is built on it.
#pragma once

#include <string>

#include "host/build/build.h"
#include "host/scene/scene.h"

namespace fascicle::build {

// Turns round tetrahedra of negative volume and counts them in the report. Throws scene::SceneError, with the
// numbers of the first culprits, for an empty mesh, corners out of range, a corner named twice, coordinates
// that are not finite, a volume of zero (below 1e-12 of the longest edge's cube), and vertices that no
// tetrahedron uses.
void check_and_orient(scene::TetMesh& mesh, const std::string& source, Report& report);

}  // namespace fascicle::build
