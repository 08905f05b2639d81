// The boundary of a tetrahedral mesh.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "host/build/body.h"
#include "host/model/model.h"

namespace fascicle::build {

// Triangles that belong to only one tetrahedron, facing outward, ordered by their corners. Throws
// scene::SceneError if three or more tetrahedra share a triangle. Tetrahedra must have positive volume.
std::vector<std::array<std::uint32_t, 3>> boundary_triangles(const mesh::TetMesh& mesh,
                                                             const std::string& source);
std::vector<std::array<std::uint32_t, 3>> boundary_triangles(const model::Model& model,
                                                             const std::string& source);

// The boundary as a render mesh. Its vertices are the boundary's, by ascending number in the mesh.
RenderMesh boundary_render_mesh(const mesh::TetMesh& mesh, const std::string& source);

}  // namespace fascicle::build
