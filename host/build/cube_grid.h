// A body's stiffness and mass for displacements interpolated on a grid of cubes. Approximates the lowest
// modes of a body of many vertices at the cost of a small one.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "host/build/region_stiffness.h"

namespace fascicle::build {

// Of the 8 corners' 24 coordinates, or of the 8 corners: the lower triangle by rows. Bits 0, 1, 2 of c give
// corner c's place along x, y, z.
using CubeStiffness = std::array<double, 300>;
using CubeMass = std::array<double, 36>;

struct CubeGrid {
  double size = 0.0;                                 // edge of a cube
  Eigen::Vector3d origin;                            // the lowest corner of the cube at 0 0 0
  std::vector<std::array<std::uint32_t, 3>> place;   // per cube, ascending by z, y, x
  std::vector<std::array<std::uint32_t, 8>> corner;  // a cube's nodes
  std::vector<std::uint32_t> parent;                 // a cube's parent in the next coarser grid
  std::vector<CubeStiffness> stiffness;
  std::vector<CubeMass> mass;
  // For each node, a cube that determines its value on a coarser grid, and which corner of that cube the node
  // is.
  struct Link {
    std::uint32_t cube, corner;
  };
  std::vector<Link> node;
};

struct BodyGrid {
  CubeGrid grid;
  std::vector<std::uint32_t> cube_of;  // per vertex whose region holds a free one
};

// Each region is strained by the interpolation of its own vertex's cube, extended to all of the region's
// vertices; held vertices stay at rest.
BodyGrid grid_of_body(const RegionStiffness& body, double size);

// The same for cubes twice as large: exact for the displacements they can represent. Sets the parents of the
// finer grid's cubes.
CubeGrid coarser_grid(CubeGrid& fine);

// Interpolates the coarser grid's displacements at the nodes of the grid it was made from.
std::vector<Eigen::Vector3d> on_finer_grid(const CubeGrid& coarse, const CubeGrid& fine,
                                           const std::vector<Eigen::Vector3d>& x);
// The transposed map, for forces.
std::vector<Eigen::Vector3d> onto_coarser_grid(const CubeGrid& coarse, const CubeGrid& fine,
                                               const std::vector<Eigen::Vector3d>& f);

// x += the grid's displacements, interpolated at the body's free vertices.
void add_on_body(const BodyGrid& grid, const RegionStiffness& body,
                 const std::vector<Eigen::Vector3d>& on_grid, std::vector<Eigen::Vector3d>& x);
// The transposed map, for forces on free vertices.
std::vector<Eigen::Vector3d> onto_grid(const BodyGrid& grid, const RegionStiffness& body,
                                       const std::vector<Eigen::Vector3d>& f);

}  // namespace fascicle::build
