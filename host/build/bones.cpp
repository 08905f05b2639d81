#include "host/build/bones.h"

#include <algorithm>
#include <cmath>

#include "host/build/surface_search.h"

namespace fascicle::build {

namespace {

// Bone points keep this many spacings from each other and from the surface.
constexpr double bone_clearance = 0.5;

}  // namespace

std::vector<Vector3d> points_along_bones(const std::vector<Bone>& bones, const mesh::SurfaceMesh& surface,
                                         double spacing) {
  const SurfaceSearch search(surface);
  std::vector<Vector3d> points;
  for (const Bone& bone : bones) {
    const double length = (bone.to - bone.from).norm();
    const auto steps = static_cast<std::size_t>(std::max(1.0, std::round(length / spacing)));
    for (std::size_t k = 0; k <= steps; ++k) {
      const Vector3d point =
          bone.from + (static_cast<double>(k) / static_cast<double>(steps)) * (bone.to - bone.from);
      const bool crowded = std::any_of(points.begin(), points.end(), [&](const Vector3d& other) {
        return (other - point).norm() < bone_clearance * spacing;
      });
      if (!crowded && !search.is_nearer_than(point, bone_clearance * spacing) && search.is_inside(point))
        points.push_back(point);
    }
  }
  return points;
}

}  // namespace fascicle::build
