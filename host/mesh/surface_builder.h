// Triangulates the polygons of a surface file.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "host/mesh/mesh.h"

namespace fascicle::mesh {

// Cutting up a concave polygon takes time with the square of its corners: a face of 20,000, or many smaller
// ones, take some 2 s.
inline constexpr double most_concave_work = 4e8;

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
  const auto append_fan = [&] {
    for (std::size_t k = 1; k + 1 < polygon.size(); ++k) append({polygon[0], polygon[k], polygon[k + 1]});
  };
  if (polygon.size() < 4 || is_covered_by_fan(mesh.vertices, polygon)) return append_fan();
  mesh.concave_work += static_cast<double>(polygon.size()) * static_cast<double>(polygon.size());
  if (mesh.concave_work > most_concave_work)
    fail("the concave faces up to here, this one with " + std::to_string(polygon.size()) +
         " corners, are too large to cut up; cut them into triangles");
  const auto triangles = cut_into_ears(mesh.vertices, polygon);
  const auto repeats = [](const auto& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; };
  if (std::any_of(triangles.begin(), triangles.end(), repeats)) return append_fan();
  for (const auto& t : triangles) append(t);
}

}  // namespace fascicle::mesh
