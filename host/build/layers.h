// Layers and pins (3.1, 3.2): which layer each vertex belongs to, and which vertices are kinematic.
#pragma once

#include <cstdint>
#include <vector>

#include "host/build/one_ring.h"
#include "host/build/where.h"

namespace fascicle::build {

// Flesh in physical units always keeps some stiffness, however it is painted.
inline constexpr double least_painted_stiffness = 0.01, most_painted_stiffness = 10.0;

struct Layering {
  std::vector<std::uint32_t> layer;  // per vertex: index into Scene::layers
  std::vector<char> kinematic;       // per vertex: in a kinematic layer, or pinned
  std::vector<double> alpha;         // per vertex, [0, 1]
  // Per vertex: the painted factor on the layer's modulus, for an implicit scene with such paint; else empty.
  std::vector<double> stiffer = {};
};

// A vertex belongs to the last layer whose painted values contain it, else to the last whose other shapes do,
// else to the last without shapes. On a character, kinematic layers that are measured from the bones are
// completed along the bones (bone_layer.h).
//
// alpha goes from the layer's alpha to its alpha_outer with the relative depth, between the least and the
// greatest depth of the layer's vertices (with the distance from the bone, if that defines the layer). It is
// then multiplied by the painted value. For an implicit scene, that value is clamped to
// least_painted_stiffness to most_painted_stiffness.
//
// Throws scene::SceneError for vertices without a layer, and for pins and kinematic layers without a vertex;
// any other empty layer is a warning. `source_vertex` converts vertices to the numbers used in messages.
Layering assign_layers(const scene::Scene& scene, WhereTest& test, Measures& measures, const OneRings& rings,
                       const std::vector<std::uint32_t>& source_vertex, Report& report);

}  // namespace fascicle::build
