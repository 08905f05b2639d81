// The lowest modes of a body of many vertices, on grids of cubes.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "host/build/cube_grid.h"
#include "host/build/region_stiffness.h"

namespace fascicle::build {

// A body's grids, each with cubes twice as large as the one before.
class CubeCascade {
 public:
  // Keeps a reference to the body. Sets `guess` to displacements of the body's vertices, 0 where held, close
  // to its lowest mode.
  CubeCascade(const RegionStiffness& body, std::vector<Eigen::Vector3d>& guess);

  // x += the sum over the grids of the inverse diagonal of the stiffness times the forces f (Bramble, Pasciak
  // and Xu 1990). With the body's own diagonal this is a preconditioner whose number of steps hardly depends
  // on the spacing.
  void add_response(const std::vector<Eigen::Vector3d>& f, std::vector<Eigen::Vector3d>& x) const;

 private:
  const RegionStiffness& body_;
  BodyGrid finest_;
  std::vector<CubeGrid> coarser_;
  std::vector<std::vector<Eigen::Vector3d>> inverse_;  // of each grid's diagonal, finest first
};

}  // namespace fascicle::build
