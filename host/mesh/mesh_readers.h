// The readers behind read_tet_mesh and read_surface_mesh: one function a format, from a file's whole content
// to a mesh. `file` is for messages only. All throw SceneError. What they return has at least one element,
// indices in range, no element that names a vertex twice, and finite coordinates; the vertices are the
// file's, unused ones too.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "host/mesh/mesh.h"

namespace fascicle::mesh {

// Of the file, before any of it is read.
inline constexpr std::uint64_t largest_mesh_file = std::uint64_t{2} << 30;

std::string read_whole_file(const std::filesystem::path& path);

TetMesh read_medit(const std::string& file, std::string_view text);
TetMesh read_tetgen(const std::string& node_file, std::string_view nodes, const std::string& ele_file,
                    std::string_view elements);
TetMesh read_gmsh(const std::string& file, std::string_view text);
TetMesh read_vtu(const std::string& file, std::string_view text);

SurfaceMesh read_off(const std::string& file, std::string_view text);
SurfaceMesh read_obj(const std::string& file, std::string_view text);
SurfaceMesh read_ply(const std::string& file, std::string_view bytes);
// Corners at equal places become one vertex; triangles that this makes degenerate are left out, which keeps a
// closed surface closed.
SurfaceMesh read_stl(const std::string& file, std::string_view bytes);

}  // namespace fascicle::mesh
