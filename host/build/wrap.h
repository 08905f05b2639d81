// The parent's side of fascicle-mesher's `report` and `wrap`.
#pragma once

#include <optional>

#include "host/build/build.h"
#include "host/scene/scene.h"

namespace fascicle::build {

// What is wrong with a surface whose equal vertices are welded. Throws scene::SceneError.
SurfaceFindings find_defects(const mesh::SurfaceMesh& surface, const BuildOptions& options);

struct WrapOrder {
  double alpha = 0.0;                     // gaps and holes narrower than this are closed over, m
  double offset = 0.0;                    // how far outside the wrap stands, m; 0: a thirtieth of alpha
  std::optional<double> edge;             // sides of the triangles, m; else
  std::optional<std::uint32_t> vertices;  // how many vertices shall fill the wrap
  double gap = 0.0;                       // what the scene asks alpha to be, m; 0: the same
};

// A closed surface that does not cross itself around any surface, facing outward, at that offset, of
// one part or several beside each other. Throws scene::SceneError.
mesh::SurfaceMesh wrap_surface(const mesh::SurfaceMesh& surface, const WrapOrder& order,
                               const BuildOptions& options);

// Leaves out the closed parts of a surface that lie inside others, and the vertices of nothing else: what a
// cavity's wall encloses becomes solid. The parts must not cross.
void drop_inner_shells(mesh::SurfaceMesh& surface);

}  // namespace fascicle::build
