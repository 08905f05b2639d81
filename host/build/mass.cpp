#include "host/build/mass.h"

namespace fascicle::build {

double total_volume(const mesh::TetMesh& mesh) {
  double volume = 0.0;
  for (const auto& t : mesh.tetrahedra) volume += signed_volume(mesh, t);
  return volume;
}

std::vector<double> lumped_volumes(const mesh::TetMesh& mesh) {
  std::vector<double> volumes(mesh.vertices.size(), 0.0);
  for (const auto& t : mesh.tetrahedra) {
    const double quarter = signed_volume(mesh, t) / 4.0;
    for (const std::uint32_t corner : t) volumes[corner] += quarter;
  }
  return volumes;
}

std::vector<double> lumped_areas(const mesh::TetMesh& mesh,
                                 const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  std::vector<double> areas(mesh.vertices.size(), 0.0);
  for (const auto& t : triangles) {
    const scene::Vector3d& a = mesh.vertices[t[0]];
    const double third = (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).norm() / 6.0;
    for (const std::uint32_t corner : t) areas[corner] += third;
  }
  return areas;
}

}  // namespace fascicle::build
