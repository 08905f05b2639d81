// What fascicle-mesher returns, checked before use: it runs on strangers' surfaces, and a flaw of its
// libraries could put anything into its files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "host/build/build.h"
#include "host/mesh/mesh.h"

namespace fascicle::build {

// A report has nine kinds of defects, and lists at most 48 vertices of each: less than 5 kB.
inline constexpr std::uint64_t most_findings_bytes = std::uint64_t{64} << 10;
// Reads the file of `report`, about a surface with so many vertices. Throws scene::SceneError.
SurfaceFindings parse_findings(const std::string& text, std::size_t vertex_count);

struct WrapLengths {
  double alpha = 0.0, offset = 0.0;  // m
};
// Reads the last line of output of `wrap`. Throws scene::SceneError.
WrapLengths parse_wrap_lengths(const std::string& line);

// Checks that `mesh` fills the surface as tetrahedralize() promises; removes the vertices that are in no
// tetrahedron, and turns all tetrahedra if their volumes are negative. Throws scene::SceneError.
void check_filling(mesh::TetMesh& mesh, const mesh::SurfaceMesh& surface);

}  // namespace fascicle::build
