// The lowest modes of a body of many vertices, on grids of cubes.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "host/build/cube_grid.h"
#include "host/build/region_stiffness.h"

namespace fascicle::build {

// A body's grids, each of cubes twice as large as those of the one before.
class CubeCascade {
 public:
  // Keeps a reference to the body. `guess` becomes displacements of the body's vertices, 0 where held, about
  // those of its lowest mode.
  CubeCascade(const RegionStiffness& body, std::vector<Eigen::Vector3d>& guess);

  // x += what each grid, by the diagonal of its stiffness, gives way under the forces f (Bramble, Pasciak and
  // Xu 1990): with the body's own diagonal a preconditioner that needs about as many steps whatever the
  // spacing.
  void add_response(const std::vector<Eigen::Vector3d>& f, std::vector<Eigen::Vector3d>& x) const;

 private:
  const RegionStiffness& body_;
  BodyGrid finest_;
  std::vector<CubeGrid> coarser_;
  std::vector<std::vector<Eigen::Vector3d>> inverse_;  // of each grid's diagonal, the finest first
};

}  // namespace fascicle::build
