#include "host/build/spacing.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Geometry>

namespace fascicle::build {

namespace {

using Edge = std::array<std::uint32_t, 2>;

template <class Cells>
std::vector<Edge> edges_of(const Cells& cells) {
  std::vector<Edge> edges;
  for (const auto& cell : cells)
    for (std::size_t i = 0; i < cell.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        edges.push_back({std::min(cell[i], cell[j]), std::max(cell[i], cell[j])});
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

double length_of(std::span<const scene::Vector3d> vertices, const Edge& edge) {
  return (vertices[edge[0]] - vertices[edge[1]]).norm();
}

Spread spread_of(std::vector<double> lengths) {
  if (lengths.empty()) return {};
  std::sort(lengths.begin(), lengths.end());
  return {lengths[lengths.size() / 100], lengths[lengths.size() - 1 - lengths.size() / 100]};
}

Spread spacing_of(std::span<const scene::Vector3d> vertices, const std::vector<Edge>& edges) {
  std::vector<double> sum(vertices.size(), 0.0), count(vertices.size(), 0.0), spacing;
  for (const Edge& edge : edges)
    for (const std::uint32_t v : edge) {
      sum[v] += length_of(vertices, edge);
      count[v] += 1.0;
    }
  for (std::size_t v = 0; v < sum.size(); ++v)
    if (count[v] > 0.0) spacing.push_back(sum[v] / count[v]);
  return spread_of(std::move(spacing));
}

}  // namespace

Spread vertex_spacing(const mesh::SurfaceMesh& surface) {
  return spacing_of(surface.vertices, edges_of(surface.triangles));
}

Spread vertex_spacing(const mesh::TetMesh& mesh) {
  return spacing_of(mesh.vertices, edges_of(mesh.tetrahedra));
}

Spread edge_lengths(const mesh::TetMesh& mesh) {
  std::vector<double> lengths;
  for (const Edge& edge : edges_of(mesh.tetrahedra)) lengths.push_back(length_of(mesh.vertices, edge));
  return spread_of(std::move(lengths));
}

double enclosed_volume(const mesh::SurfaceMesh& surface) {
  const scene::Vector3d& origin = surface.vertices[0];
  double sum = 0.0;
  for (const auto& t : surface.triangles)
    sum += (surface.vertices[t[0]] - origin)
               .dot((surface.vertices[t[1]] - origin).cross(surface.vertices[t[2]] - origin));
  return sum / 6.0;
}

}  // namespace fascicle::build
