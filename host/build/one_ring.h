// One-rings: the vertices of each region.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace fascicle::build {

// CSR, ascending, without the vertex itself; symmetric.
struct OneRings {
  std::vector<std::uint32_t> offset;
  std::vector<std::uint32_t> neighbour;

  std::size_t size() const { return offset.size() - 1; }
  std::uint32_t degree(std::size_t i) const { return offset[i + 1] - offset[i]; }
  std::span<const std::uint32_t> operator[](std::size_t i) const {
    return {neighbour.data() + offset[i], neighbour.data() + offset[i + 1]};
  }
};

OneRings one_rings(std::size_t vertex_count, const std::vector<std::array<std::uint32_t, 4>>& tetrahedra);

// For each entry (r, i), the place of entry (i, r).
std::vector<std::uint32_t> mirror_entries(const OneRings& rings);

// The connected part that each vertex belongs to; parts are numbered by their lowest vertex.
struct Parts {
  std::uint32_t count = 0;
  std::vector<std::uint32_t> of_vertex;
};
Parts connected_parts(const OneRings& rings);

}  // namespace fascicle::build
