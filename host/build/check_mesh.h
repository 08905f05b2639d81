// Requirements on a tetrahedral mesh before anything is built on it.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "host/build/build.h"
#include "host/scene/scene.h"

namespace fascicle::build {

// Reorients tetrahedra of negative volume and counts them in the report. Throws scene::SceneError, with the
// numbers of the first offenders, for an empty mesh, corners out of range, repeated corners, coordinates that
// are not finite, zero volume (below 1e-12 of the longest edge's cube), and vertices that no tetrahedron
// uses.
void check_and_orient(mesh::TetMesh& mesh, const std::string& source, Report& report);

// Numbers of the tetrahedra with zero volume by the same measure. All corners must be in range.
std::vector<std::uint32_t> tetrahedra_without_volume(const mesh::TetMesh& mesh);

// A tetrahedron's least height divided by the side of a square with twice its largest face's area: 0.88 for a
// regular one, 1/n for one cut out of a box n times as wide as it is high.
double flatness(const mesh::TetMesh& mesh, const std::array<std::uint32_t, 4>& tetrahedron);

// Warns of soft vertices whose tetrahedra are all flatter than 1:20, as in meshes that get finer towards one
// end. There rounding moves flesh by 0.001 of the body's length and more. A sliver among good tetrahedra is
// harmless. Up to 0.1 % of the soft vertices are not worth a warning unless some are flatter than 1:30.
// `source_vertex` has the numbers for the message.
void warn_of_flat_tetrahedra(const mesh::TetMesh& mesh, const std::vector<char>& is_kinematic,
                             const std::vector<std::uint32_t>& source_vertex, Report& report);

}  // namespace fascicle::build
