// The visible parts of a model: its render mesh with its creases, the outside of its tetrahedra, and their
// layers.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "host/model/model.h"

namespace fascicle::render {

// Removes the tetrahedra that lie wholly on one side of a plane in the rest pose, so that every frame shows
// the same cut.
struct Clip {
  int axis = 0;        // 0 x, 1 y, 2 z
  double place = 0.0;  // m
  bool keeps_below = true;
};

// The render mesh with an extra vertex for each crease through a vertex, so that every vertex has one normal.
struct CreasedSurface {
  std::vector<std::uint32_t> vertex;                    // the render vertex
  std::vector<std::uint32_t> normal;                    // the index of its normal, shared across seams
  std::vector<std::array<std::uint32_t, 3>> triangles;  // indices into `vertex`
};
CreasedSurface creased_surface(const model::Model& model);

// A face that belongs to only one tetrahedron.
struct OuterFace {
  std::array<std::uint32_t, 3> corners;  // vertices of the model, counter-clockwise seen from outside
  std::uint32_t tetrahedron;
};
// The outer faces of the tetrahedra that a clip leaves.
std::vector<OuterFace> outer_faces(const model::Model& model, const std::optional<Clip>& clip = {});

// The layer with the largest share of a render vertex.
std::uint32_t layer_of_surface_vertex(const model::Model& model, std::uint32_t s);
// The layer of most corners of a tetrahedron; in a tie, the lowest.
std::uint32_t layer_of_tetrahedron(const model::Model& model, std::uint32_t t);

}  // namespace fascicle::render
