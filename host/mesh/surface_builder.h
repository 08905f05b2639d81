// Triangulates the polygons of a surface file.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "host/mesh/mesh.h"

namespace fascicle::mesh {

// Cutting up a concave polygon takes time with the square of its corners.
inline constexpr std::size_t most_concave_corners = 10000;

// Whether the fan around a polygon's first corner covers it, with no triangle turned over.
bool is_covered_by_fan(const std::vector<Vector3d>& vertices, const std::vector<std::uint32_t>& polygon);

// Triangles that cover a concave polygon, by cutting off ears. Where it crosses itself, its rest becomes a
// fan.
std::vector<std::array<std::uint32_t, 3>> cut_into_ears(const std::vector<Vector3d>& vertices,
                                                        std::vector<std::uint32_t> polygon);

// Removes corners that repeat the one before them, the last before the first. Returns how many.
std::size_t drop_repeated_corners(std::vector<std::uint32_t>& polygon);

// Appends a polygon, as a fan around its first corner if that is right. Calls `fail`, which must throw, with
// the reason; `base` is the number of the file's first vertex.
template <typename Fail>
void append_polygon(SurfaceMesh& mesh, std::vector<std::uint32_t>& polygon, std::uint32_t base, Fail fail) {
  if (polygon.size() < 3) {
    fail("a face with " + std::to_string(polygon.size()) + " corners, fewer than 3; remove it");
  }
  mesh.repeated_corners += drop_repeated_corners(polygon);
  const auto append = [&](const std::array<std::uint32_t, 3>& t) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
      fail("a face names vertex " + std::to_string((t[0] == t[1] || t[2] == t[0] ? t[0] : t[1]) + base) +
           " (counted from " + std::to_string(base) + ") twice; remove it");
    }
    mesh.triangles.push_back(t);
  };
  if (polygon.size() < 4 || is_covered_by_fan(mesh.vertices, polygon)) {
    for (std::size_t k = 1; k + 1 < polygon.size(); ++k) append({polygon[0], polygon[k], polygon[k + 1]});
    return;
  }
  if (polygon.size() > most_concave_corners) {
    fail("a concave face with " + std::to_string(polygon.size()) + " corners, more than " +
         std::to_string(most_concave_corners) + "; cut it into triangles");
  }
  for (const auto& t : cut_into_ears(mesh.vertices, polygon)) append(t);
}

}  // namespace fascicle::mesh
