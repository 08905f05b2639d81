// The caller's side of fascicle-mesher's `report` and `wrap`.
#pragma once

#include <optional>

#include "host/build/build.h"
#include "host/scene/scene.h"

namespace fascicle::build {

// Finds the defects of a welded surface. Throws scene::SceneError.
SurfaceFindings find_defects(const mesh::SurfaceMesh& surface, const BuildOptions& options);

struct WrapOrder {
  double alpha = 0.0;                     // gaps and holes narrower than about twice this are closed, m
  double offset = 0.0;                    // distance of the wrap from the surface, m; 0: a thirtieth of alpha
  std::optional<double> edge;             // sides of the triangles, m; else
  std::optional<std::uint32_t> vertices;  // target number of vertices in the filled wrap
  double gap = 0.0;                       // the alpha that the scene requests, m; 0: the same as alpha
};

struct Wrap {
  mesh::SurfaceMesh surface;
  // Those used. Thin parts may need larger ones than ordered: triangles of that size would cross there.
  double alpha = 0.0, offset = 0.0;
};

// A closed surface without self-intersections around any surface, facing outward, at that offset, in one part
// or several separate ones. Throws scene::SceneError.
Wrap wrap_surface(const mesh::SurfaceMesh& surface, const WrapOrder& order, const BuildOptions& options);

// Removes closed parts of a surface that lie inside others, and their unused vertices: cavities become solid.
// The parts must not cross.
void drop_inner_shells(mesh::SurfaceMesh& surface);

}  // namespace fascicle::build
