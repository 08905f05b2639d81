// What of a model is seen: its render mesh with its creases, the outside of its tetrahedra, and their layers.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "host/model/model.h"

namespace fascicle::render {

// Takes away the tetrahedra that lie wholly on one side of a plane in the rest pose, so that it cuts the same
// tetrahedra in every frame.
struct Clip {
  int axis = 0;        // 0 x, 1 y, 2 z
  double place = 0.0;  // m
  bool keeps_below = true;
};

// The render mesh with a vertex more for each crease that runs through it, so that one vertex has one normal.
struct CreasedSurface {
  std::vector<std::uint32_t> vertex;                    // the render vertex
  std::vector<std::uint32_t> normal;                    // its normal's number, shared across seams
  std::vector<std::array<std::uint32_t, 3>> triangles;  // numbers of `vertex`
};
CreasedSurface creased_surface(const model::Model& model);

// A side of one tetrahedron and of no other.
struct OuterFace {
  std::array<std::uint32_t, 3> corners;  // vertices of the model, turning left seen from outside
  std::uint32_t tetrahedron;
};
// Of the tetrahedra that a clip leaves.
std::vector<OuterFace> outer_faces(const model::Model& model, const std::optional<Clip>& clip = {});

// The layer that has most of a render vertex.
std::uint32_t layer_of_surface_vertex(const model::Model& model, std::uint32_t s);
// The layer that most corners of a tetrahedron are of; of equals the lowest.
std::uint32_t layer_of_tetrahedron(const model::Model& model, std::uint32_t t);

}  // namespace fascicle::render
