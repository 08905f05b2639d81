// The mesh that paint files refer to.
#pragma once

#include "host/mesh/mesh.h"

namespace fascicle::fuzz {

inline mesh::SurfaceMesh painted_surface() {
  mesh::SurfaceMesh surface;
  surface.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  surface.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  return surface;
}

}  // namespace fascicle::fuzz
