// Mesh files. Readers validate what they read: counts against the file's size before allocating memory,
// indices, finite coordinates. They throw SceneError with file and line (or byte).
#pragma once

#include <filesystem>

#include "host/mesh/mesh.h"

namespace fascicle::mesh {

// By extension: MEDIT .mesh, TetGen .node/.ele (either one stands for both), Gmsh 2.2 ASCII .msh, ASCII .vtu.
bool is_tet_mesh_file(const std::filesystem::path& path);
TetMesh read_tet_mesh(const std::filesystem::path& path);

// .off .obj .ply (ASCII and binary) .stl (ASCII and binary; equal corners are welded).
bool is_surface_mesh_file(const std::filesystem::path& path);
SurfaceMesh read_surface_mesh(const std::filesystem::path& path);

// Writes a surface as OFF with full precision; throws std::system_error.
void write_off(const std::filesystem::path& path, const SurfaceMesh& mesh);

}  // namespace fascicle::mesh
