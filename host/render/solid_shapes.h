// Shapes that show a scene's solids.
#pragma once

#include <Eigen/Core>

#include "host/render/shape.h"

namespace fascicle::render {

// A box whose edges are rounded by `radius` or, with `is_plane`, a square of side 2 `reach` around the point
// of the plane y = radius that is nearest to `middle`. `axes` (a rotation) and `center` map the solid's own
// space to the scene, m.
struct DrawnSolid {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Vector3d half_size = Eigen::Vector3d::Zero();
  double radius = 0.0;
  bool is_plane = false;
};
Shape solid_shape(const DrawnSolid& solid, const Eigen::Vector3d& middle, double reach);

}  // namespace fascicle::render
