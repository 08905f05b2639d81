// Finds weights for vertices that follow no joint.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace fascicle::gltf {

inline constexpr std::uint32_t no_vertex = ~std::uint32_t{0};

// For each vertex, the vertex whose weights it takes: itself if it has weights, else the nearest one along
// triangle edges that has; ties go to the one reached first in triangle order; no_vertex if none is
// connected.
std::vector<std::uint32_t> weighted_neighbours(const std::vector<bool>& has_weights,
                                               std::span<const std::array<std::uint32_t, 3>> triangles);

}  // namespace fascicle::gltf
