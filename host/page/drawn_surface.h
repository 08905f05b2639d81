// What a page draws of a model, and the numbers that its vertices have elsewhere.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "host/model/model.h"

namespace fascicle::page {

// Vertices as a graphics card wants them: one place, one normal and one layer each.
struct DrawnSurface {
  bool is_tetrahedra = false;         // the outside of the tetrahedra; else the render mesh
  std::vector<std::uint32_t> source;  // the render vertex, or the model's
  std::vector<std::uint32_t> normal;  // vertices of one number share it
  std::vector<std::uint32_t> layer;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

// Of the render mesh, or of the tetrahedra where there is none. Throws BakeError where neither is there.
DrawnSurface drawn_surface(const model::Model& model);

// Sorts the triangles by a number each, of equals in the order that they had, and numbers vertices as the
// triangles then meet them. Of each number that occurs: itself and the triangles that have it.
struct TriangleGroup {
  std::uint32_t number = 0, count = 0;
};
std::vector<TriangleGroup> group_triangles(DrawnSurface& surface, std::span<const std::uint32_t> numbers);

}  // namespace fascicle::page
