#include "host/build/one_ring.h"

#include <algorithm>
#include <limits>

namespace fascicle::build {

namespace {

struct Incidence {
  std::vector<std::uint32_t> offset;
  std::vector<std::uint32_t> tetrahedron;
};

Incidence tetrahedra_of_vertices(std::size_t vertex_count,
                                 const std::vector<std::array<std::uint32_t, 4>>& tetrahedra) {
  Incidence incidence;
  incidence.offset.assign(vertex_count + 1, 0);
  for (const auto& t : tetrahedra)
    for (const std::uint32_t corner : t) ++incidence.offset[corner + 1];
  for (std::size_t i = 0; i < vertex_count; ++i) incidence.offset[i + 1] += incidence.offset[i];
  incidence.tetrahedron.resize(4 * tetrahedra.size());
  std::vector<std::uint32_t> next(incidence.offset.begin(), incidence.offset.end() - 1);
  for (std::uint32_t k = 0; k < tetrahedra.size(); ++k)
    for (const std::uint32_t corner : tetrahedra[k]) incidence.tetrahedron[next[corner]++] = k;
  return incidence;
}

}  // namespace

OneRings one_rings(std::size_t vertex_count, const std::vector<std::array<std::uint32_t, 4>>& tetrahedra) {
  const Incidence incidence = tetrahedra_of_vertices(vertex_count, tetrahedra);
  OneRings rings;
  rings.offset.assign(vertex_count + 1, 0);
  std::vector<std::uint32_t> ring;
  for (std::uint32_t i = 0; i < vertex_count; ++i) {
    ring.clear();
    for (std::uint32_t k = incidence.offset[i]; k < incidence.offset[i + 1]; ++k)
      for (const std::uint32_t corner : tetrahedra[incidence.tetrahedron[k]])
        if (corner != i) ring.push_back(corner);
    std::sort(ring.begin(), ring.end());
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
    rings.neighbour.insert(rings.neighbour.end(), ring.begin(), ring.end());
    rings.offset[i + 1] = static_cast<std::uint32_t>(rings.neighbour.size());
  }
  rings.neighbour.shrink_to_fit();
  return rings;
}

std::vector<std::uint32_t> mirror_entries(const OneRings& rings) {
  // Rows are visited in ascending order, so row i is met by its neighbours in the order in which it lists
  // them.
  std::vector<std::uint32_t> mirror(rings.neighbour.size());
  std::vector<std::uint32_t> next(rings.offset.begin(), rings.offset.end() - 1);
  for (std::size_t r = 0; r < rings.size(); ++r)
    for (std::uint32_t k = rings.offset[r]; k < rings.offset[r + 1]; ++k)
      mirror[k] = next[rings.neighbour[k]]++;
  return mirror;
}

Parts connected_parts(const OneRings& rings) {
  constexpr std::uint32_t unseen = std::numeric_limits<std::uint32_t>::max();
  Parts parts;
  parts.of_vertex.assign(rings.size(), unseen);
  std::vector<std::uint32_t> open;
  for (std::uint32_t start = 0; start < rings.size(); ++start) {
    if (parts.of_vertex[start] != unseen) continue;
    parts.of_vertex[start] = parts.count;
    open.push_back(start);
    while (!open.empty()) {
      const std::uint32_t i = open.back();
      open.pop_back();
      for (const std::uint32_t j : rings[i])
        if (parts.of_vertex[j] == unseen) {
          parts.of_vertex[j] = parts.count;
          open.push_back(j);
        }
    }
    ++parts.count;
  }
  return parts;
}

}  // namespace fascicle::build
