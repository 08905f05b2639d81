// Vertices that follow no joint among others that do.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace fascicle::gltf {

inline constexpr std::uint32_t no_vertex = ~std::uint32_t{0};

// For each vertex the one whose weights it has: itself where it has some, else the nearest along the
// triangles' sides that has, of equally near ones the one that is reached first in the triangles' order;
// no_vertex where none is connected with it.
std::vector<std::uint32_t> weighted_neighbours(const std::vector<bool>& has_weights,
                                               std::span<const std::array<std::uint32_t, 3>> triangles);

}  // namespace fascicle::gltf
