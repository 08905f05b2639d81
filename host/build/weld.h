// Surfaces as files hold them, with seams, turned into surfaces that can be filled.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/build/build.h"
#include "host/scene/scene.h"

namespace fascicle::build {

struct WeldedSurface {
  mesh::SurfaceMesh surface;             // no duplicate vertices, every vertex in a triangle
  std::vector<std::uint32_t> of_vertex;  // for each input vertex: its vertex in `surface`
  // For each input vertex: its number in the file. Empty if the whole file is given.
  std::vector<std::uint32_t> file_vertex = {};
};

// The file's number of an input vertex.
inline std::uint32_t number_in_file(const WeldedSurface& welded, std::uint32_t vertex) {
  return welded.file_vertex.empty() ? vertex : welded.file_vertex[vertex];
}

// Merges vertices within 1e-9 of the bounding box's diagonal of each other; the first keeps its position, and
// the order is kept. Triangles that lose a corner are dropped, with a warning. A vertex in no triangle
// follows the nearest vertex that is in one, with a warning. Throws scene::SceneError for a surface without
// triangles, corners out of range and coordinates that are not finite.
WeldedSurface weld(const mesh::SurfaceMesh& surface, const std::string& source, Report& report);

// Mean length of the triangles' sides, m.
double mean_edge(const mesh::SurfaceMesh& surface);

}  // namespace fascicle::build
