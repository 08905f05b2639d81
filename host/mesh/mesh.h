// Meshes as stored in their files.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace fascicle::mesh {

using Eigen::Vector3d;

struct TetMesh {
  std::vector<Vector3d> vertices;
  std::vector<std::array<std::uint32_t, 4>> tetrahedra;
};

struct SurfaceMesh {
  std::vector<Vector3d> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::uint64_t repeated_corners = 0;  // of the file's faces, left out
  double concave_work = 0.0;           // corners squared, summed over its concave faces
};

}  // namespace fascicle::mesh
