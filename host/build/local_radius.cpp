#include "host/build/local_radius.h"

#include <algorithm>
#include <cstdint>
#include <queue>
#include <tuple>

#include "host/build/one_ring.h"

namespace fascicle::build {

namespace {

constexpr double reach_in_radii = 1.5 + 1e-6;  // the vertices of cube meshes lie exactly at the limit

// Half the mean edge length at each vertex.
std::vector<double> half_edges(const mesh::TetMesh& mesh, const OneRings& rings) {
  std::vector<double> half(mesh.vertices.size(), 0.0);
  for (std::size_t i = 0; i < half.size(); ++i) {
    for (const std::uint32_t j : rings[i]) half[i] += (mesh.vertices[i] - mesh.vertices[j]).norm();
    if (rings.degree(i) > 0) half[i] /= 2.0 * rings.degree(i);
  }
  return half;
}

}  // namespace

std::vector<double> local_radii(const mesh::TetMesh& mesh, const std::vector<double>& from_skin) {
  const OneRings rings = one_rings(mesh.vertices.size(), mesh.tetrahedra);
  const std::vector<double> half = half_edges(mesh, rings);
  // Balls spread from their centres, the largest first: a vertex belongs to the first ball that reaches it. A
  // smaller ball continues through it only if it reaches farther beyond it than those before.
  using Reach = std::tuple<double, std::uint32_t, std::uint32_t>;  // radius, centre, vertex
  std::priority_queue<Reach> open;
  for (std::uint32_t i = 0; i < half.size(); ++i) open.emplace(std::max(from_skin[i], half[i]), i, i);
  std::vector<double> radius(half.size(), 0.0), beyond(half.size(), -1.0);
  std::vector<char> is_reached(half.size(), 0);  // by a ball whose centre lies inside
  while (!open.empty()) {
    const auto [r, centre, vertex] = open.top();
    open.pop();
    const auto left = [&, r = r, centre = centre](std::uint32_t i) {
      return reach_in_radii * r - (mesh.vertices[i] - mesh.vertices[centre]).norm();
    };
    if (left(vertex) <= beyond[vertex]) continue;
    beyond[vertex] = left(vertex);
    radius[vertex] = std::max(radius[vertex], r);
    if (from_skin[centre] >= half[centre]) is_reached[vertex] = 1;
    for (const std::uint32_t next : rings[vertex])
      if (left(next) > std::max(beyond[next], 0.0)) open.emplace(r, centre, next);
  }
  // Corners and sharp edges that no such ball reaches take the thickness within two edges.
  std::vector<double> result = radius;
  for (std::uint32_t i = 0; i < radius.size(); ++i) {
    if (is_reached[i]) continue;
    for (const std::uint32_t near : rings[i])
      for (const std::uint32_t next : rings[near])
        if (is_reached[next]) result[i] = std::max(result[i], radius[next]);
  }
  return result;
}

}  // namespace fascicle::build
