// Layers and pins (3.1, 3.2): which layer each vertex belongs to, and which vertices are kinematic.
#pragma once

#include <cstdint>
#include <vector>

#include "host/build/one_ring.h"
#include "host/build/where.h"

namespace fascicle::build {

// Flesh in physical units is never without stiffness, however it is painted.
inline constexpr double least_painted_stiffness = 0.01, most_painted_stiffness = 10.0;

struct Layering {
  std::vector<std::uint32_t> layer;  // a vertex: index into Scene::layers
  std::vector<char> kinematic;       // a vertex: in a kinematic layer, or pinned
  std::vector<double> alpha;         // a vertex, [0, 1]
  // Of an implicit scene with paint for it, a vertex: what the layer's modulus is multiplied by; else empty.
  std::vector<double> stiffer = {};
};

// The last layer whose painted values hold the vertex, else the last whose other shapes do, else the last
// without shapes. On a character, kinematic layers that are measured from the bones are completed along them
// (bone_layer.h).
//
// alpha goes from the layer's alpha to its alpha_outer with the relative depth, from the least that the
// layer's vertices have to the greatest (with the distance from the bone, where the layer is made by that),
// and is multiplied by what is painted. Of an implicit scene that is taken from least_painted_stiffness to
// most_painted_stiffness.
//
// Throws scene::SceneError for vertices that no layer takes, and for pins and kinematic layers without a
// vertex; any other empty layer is a warning. `source_vertex` turns vertices into the numbers that messages
// use.
Layering assign_layers(const scene::Scene& scene, WhereTest& test, Measures& measures, const OneRings& rings,
                       const std::vector<std::uint32_t>& source_vertex, Report& report);

}  // namespace fascicle::build
