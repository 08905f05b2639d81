// Layers and pins (3.1, 3.2): which layer each vertex belongs to, and which vertices are kinematic.
#pragma once

#include <cstdint>
#include <vector>

#include "host/build/where.h"

namespace fascicle::build {

struct Layering {
  std::vector<std::uint32_t> layer;  // a vertex: index into Scene::layers
  std::vector<char> kinematic;       // a vertex: in a kinematic layer, or pinned
};

// The last layer whose shapes hold the vertex, else the last layer without shapes. Throws scene::SceneError
// for vertices that no layer takes, and for pins and kinematic layers that hold no vertex; any other empty
// layer is a warning. `source_vertex` turns vertices into the numbers that messages use.
Layering assign_layers(const scene::Scene& scene, WhereTest& test,
                       const std::vector<std::uint32_t>& source_vertex, Report& report);

}  // namespace fascicle::build
