// Forces other than gravity: which vertices take how much of them.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "host/build/layers.h"
#include "host/build/where.h"

namespace fascicle::build {

// CSR as in Model; empty without forces.
struct ForceTable {
  std::vector<std::uint32_t> offset;
  std::vector<std::uint32_t> index;
  std::vector<float> coefficient;
};

// wind: rest area (m^2) over mass, for the vertices of `boundary`. point: 1 over the mass of the affected
// vertices. Kinematic vertices take none. Throws scene::SceneError for a point force that affects no free
// vertex.
ForceTable make_forces(const scene::Scene& scene, const Body& body, WhereTest& test,
                       const std::vector<std::array<std::uint32_t, 3>>& boundary,
                       const std::vector<double>& mass, const std::vector<char>& kinematic);

}  // namespace fascicle::build
