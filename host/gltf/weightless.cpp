#include "host/gltf/weightless.h"

#include <algorithm>
#include <numeric>

namespace fascicle::gltf {

std::vector<std::uint32_t> weighted_neighbours(const std::vector<bool>& has_weights,
                                               std::span<const std::array<std::uint32_t, 3>> triangles) {
  const std::size_t count = has_weights.size();
  std::vector<std::uint32_t> source(count, no_vertex);
  std::vector<std::uint32_t> reached;  // in breadth-first order
  for (std::uint32_t v = 0; v < count; ++v) {
    if (!has_weights[v]) continue;
    source[v] = v;
    reached.push_back(v);
  }
  if (reached.size() == count) return source;
  // The triangles of each vertex.
  std::vector<std::size_t> first(count + 1, 0);
  for (const auto& t : triangles)
    for (const std::uint32_t corner : t) ++first[corner + 1];
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<std::size_t> of_vertex(first.back()), next(first.begin(), first.end() - 1);
  for (std::size_t k = 0; k < triangles.size(); ++k)
    for (const std::uint32_t corner : triangles[k]) of_vertex[next[corner]++] = k;
  for (std::size_t at = 0; at < reached.size(); ++at)
    for (std::size_t k = first[reached[at]]; k < first[reached[at] + 1]; ++k)
      for (const std::uint32_t corner : triangles[of_vertex[k]]) {
        if (source[corner] != no_vertex) continue;
        source[corner] = source[reached[at]];
        reached.push_back(corner);
      }
  return source;
}

}  // namespace fascicle::gltf
