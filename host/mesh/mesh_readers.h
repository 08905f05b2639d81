// The readers behind read_tet_mesh and read_surface_mesh: one function per format, from a file's whole
// content to a mesh. `file` is for messages only. All throw SceneError. The result has at least one element,
// indices in range, no element that uses a vertex twice, and finite coordinates; its vertices are those of
// the file, including unused ones.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "host/mesh/mesh.h"

namespace fascicle::mesh {

// Size limit, checked before reading.
inline constexpr std::uint64_t largest_mesh_file = std::uint64_t{2} << 30;

std::string read_whole_file(const std::filesystem::path& path);

// "1 volume cell is not a tetrahedron of four vertices": left out, it would leave a hole in the body.
std::string other_cells(std::size_t count);

TetMesh read_medit(const std::string& file, std::string_view text);
TetMesh read_tetgen(const std::string& node_file, std::string_view nodes, const std::string& ele_file,
                    std::string_view elements);
TetMesh read_gmsh(const std::string& file, std::string_view text);
TetMesh read_vtu(const std::string& file, std::string_view text);

SurfaceMesh read_off(const std::string& file, std::string_view text);
SurfaceMesh read_obj(const std::string& file, std::string_view text);
SurfaceMesh read_ply(const std::string& file, std::string_view bytes);
// Corners at equal positions become one vertex; triangles that become degenerate are dropped, which keeps a
// closed surface closed.
SurfaceMesh read_stl(const std::string& file, std::string_view bytes);

}  // namespace fascicle::mesh
