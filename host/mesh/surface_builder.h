// Triangulates the polygons of a surface file.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/mesh/mesh.h"

namespace fascicle::mesh {

// Appends a polygon as a fan around its first corner. Calls `fail`, which must throw, with the reason.
template <typename Fail>
void append_polygon(SurfaceMesh& mesh, const std::vector<std::uint32_t>& polygon, Fail fail) {
  if (polygon.size() < 3) {
    fail("a face with " + std::to_string(polygon.size()) + " corners, fewer than 3; remove it");
  }
  for (std::size_t k = 1; k + 1 < polygon.size(); ++k) {
    const std::array<std::uint32_t, 3> t = {polygon[0], polygon[k], polygon[k + 1]};
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
      fail("a face names vertex " + std::to_string(t[0] == t[1] || t[2] == t[0] ? t[0] : t[1]) +
           " (counted from 0) twice; remove it");
    }
    mesh.triangles.push_back(t);
  }
}

}  // namespace fascicle::mesh
