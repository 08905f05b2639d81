// The surface of a model that a page draws, and its vertices' indices in the model.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "host/model/model.h"

namespace fascicle::page {

// GPU-ready vertices: one position, one normal and one layer each.
struct DrawnSurface {
  bool is_tetrahedra = false;         // the boundary of the tetrahedra; else the render mesh
  std::vector<std::uint32_t> source;  // index of the render vertex, or of the model's
  std::vector<std::uint32_t> normal;  // vertices with equal numbers share a normal
  std::vector<std::uint32_t> layer;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

// Of the render mesh, or of the tetrahedra if there is none. Throws BakeError if there are neither.
DrawnSurface drawn_surface(const model::Model& model);

// Sorts the triangles by their numbers (stable), and renumbers vertices in the order in which the sorted
// triangles use them. Returns each number that occurs and how many triangles have it.
struct TriangleGroup {
  std::uint32_t number = 0, count = 0;
};
std::vector<TriangleGroup> group_triangles(DrawnSurface& surface, std::span<const std::uint32_t> numbers);

}  // namespace fascicle::page
