// A body's stiffness and mass seen by displacements that a grid of cubes interpolates: for the lowest modes
// of many vertices, roughly, in the time that a few take.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "host/build/region_stiffness.h"

namespace fascicle::build {

// Of the 8 corners' 24 coordinates, or of the corners: the lower triangle by rows. Corner c lies at bits
// 0, 1, 2 of c along x, y, z.
using CubeStiffness = std::array<double, 300>;
using CubeMass = std::array<double, 36>;

struct CubeGrid {
  double size = 0.0;                                 // a cube's edge
  Eigen::Vector3d origin;                            // the lowest corner of the cube at 0 0 0
  std::vector<std::array<std::uint32_t, 3>> place;   // of each cube, ascending by z, y, x
  std::vector<std::array<std::uint32_t, 8>> corner;  // a cube's nodes
  std::vector<std::uint32_t> parent;                 // a cube's, in the next coarser grid
  std::vector<CubeStiffness> stiffness;
  std::vector<CubeMass> mass;
  // Of each node the cube that says what a coarser grid means there, and which of its corners it is.
  struct Link {
    std::uint32_t cube, corner;
  };
  std::vector<Link> node;
};

struct BodyGrid {
  CubeGrid grid;
  std::vector<std::uint32_t> cube_of;  // of each vertex whose region holds a free one
};

// Each region is strained by what its own vertex's cube says of all its vertices, the held ones at rest.
BodyGrid grid_of_body(const RegionStiffness& body, double size);

// The same of cubes twice as large: exact for what they can say. The finer grid learns its cubes' parents.
CubeGrid coarser_grid(CubeGrid& fine);

// What the coarser grid's displacements are at the nodes of the grid that it was made of.
std::vector<Eigen::Vector3d> on_finer_grid(const CubeGrid& coarse, const CubeGrid& fine,
                                           const std::vector<Eigen::Vector3d>& x);
// The transposed map, of forces.
std::vector<Eigen::Vector3d> onto_coarser_grid(const CubeGrid& coarse, const CubeGrid& fine,
                                               const std::vector<Eigen::Vector3d>& f);

// x += what the grid's displacements are at the body's free vertices.
void add_on_body(const BodyGrid& grid, const RegionStiffness& body,
                 const std::vector<Eigen::Vector3d>& on_grid, std::vector<Eigen::Vector3d>& x);
// The transposed map, of forces on free vertices.
std::vector<Eigen::Vector3d> onto_grid(const BodyGrid& grid, const RegionStiffness& body,
                                       const std::vector<Eigen::Vector3d>& f);

}  // namespace fascicle::build
