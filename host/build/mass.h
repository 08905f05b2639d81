// Volumes, and lumped quantities derived from them.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "host/scene/scene.h"

namespace fascicle::build {

// Positive if the first three corners are anticlockwise when seen from the fourth.
inline double signed_volume(const scene::Vector3d& a, const scene::Vector3d& b, const scene::Vector3d& c,
                            const scene::Vector3d& d) {
  return (b - a).cross(c - a).dot(d - a) / 6.0;
}
inline double signed_volume(const mesh::TetMesh& mesh, const std::array<std::uint32_t, 4>& t) {
  return signed_volume(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]], mesh.vertices[t[3]]);
}

double total_volume(const mesh::TetMesh& mesh);

// For each vertex, a quarter of the volume of each of its tetrahedra, m^3. Times the density this is m_i of
// equation (4).
std::vector<double> lumped_volumes(const mesh::TetMesh& mesh);

// For each vertex, a third of the area of each of its triangles, m^2.
std::vector<double> lumped_areas(const mesh::TetMesh& mesh,
                                 const std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace fascicle::build
