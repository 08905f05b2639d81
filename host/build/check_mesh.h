// What a tetrahedral mesh must be before anything is built on it.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "host/build/build.h"
#include "host/scene/scene.h"

namespace fascicle::build {

// Turns round tetrahedra of negative volume and counts them in the report. Throws scene::SceneError, with the
// numbers of the first culprits, for an empty mesh, corners out of range, a corner named twice, coordinates
// that are not finite, a volume of zero (below 1e-12 of the longest edge's cube), and vertices that no
// tetrahedron uses.
void check_and_orient(mesh::TetMesh& mesh, const std::string& source, Report& report);

// Numbers of those whose volume is zero by the same measure. All corners must be in range.
std::vector<std::uint32_t> tetrahedra_without_volume(const mesh::TetMesh& mesh);

// A tetrahedron's least height over the side of a square of twice its largest face: 0.88 of a regular one,
// 1/n of one cut out of a box n times as wide as it is high.
double flatness(const mesh::TetMesh& mesh, const std::array<std::uint32_t, 4>& tetrahedron);

// Warns of soft vertices all of whose tetrahedra are flatter than 1:20, as meshes are that get finer towards
// one end: there rounding moves flesh by 0.001 of the body's length and more. A sliver among good ones costs
// nothing. `source_vertex` has the numbers to name.
void warn_of_flat_tetrahedra(const mesh::TetMesh& mesh, const std::vector<char>& is_kinematic,
                             const std::vector<std::uint32_t>& source_vertex, Report& report);

}  // namespace fascicle::build
