#include "host/build/bones.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/LU>

#include "host/build/message.h"
#include "host/build/surface_search.h"

namespace fascicle::build {

namespace {

// Bones shorter than this part of the skeleton's extent are points.
constexpr double point_of_extent = 1e-6;
// Bone points keep this many spacings from each other and from the surface.
constexpr double clearance = 0.5;

std::optional<Vector3d> bind_position(const scene::Joint& joint) {
  const Eigen::FullPivLU<Eigen::Matrix4d> factored(joint.inverse_bind);
  if (!joint.inverse_bind.allFinite() || !factored.isInvertible()) return std::nullopt;
  const Eigen::Vector4d origin = factored.solve(Eigen::Vector4d(0, 0, 0, 1));
  return Vector3d(origin.head<3>() / origin[3]);
}

// The next joint upwards that skins, or -1.
std::int32_t skinning_parent(const std::vector<scene::Joint>& skeleton, std::int32_t joint) {
  std::int32_t parent = skeleton[static_cast<std::size_t>(joint)].parent;
  while (parent >= 0 && !skeleton[static_cast<std::size_t>(parent)].skins)
    parent = skeleton[static_cast<std::size_t>(parent)].parent;
  return parent;
}

}  // namespace

std::vector<Bone> skeleton_bones(const std::vector<scene::Joint>& skeleton, double scale,
                                 const std::string& source) {
  std::vector<Vector3d> place(skeleton.size(), Vector3d::Zero());
  std::optional<Vector3d> low, high;
  for (std::size_t j = 0; j < skeleton.size(); ++j) {
    if (!skeleton[j].skins) continue;
    const std::optional<Vector3d> position = bind_position(skeleton[j]);
    if (!position) fail(source, "joint \"" + skeleton[j].name + "\": its inverse bind matrix has no inverse");
    place[j] = *position * scale;
    low = low ? Vector3d(low->cwiseMin(place[j])) : place[j];
    high = high ? Vector3d(high->cwiseMax(place[j])) : place[j];
  }
  if (!low) return {};
  const double shortest = point_of_extent * (*high - *low).norm();

  std::vector<Bone> bones;
  std::vector<char> leads_on(skeleton.size(), 0);
  for (std::size_t j = 0; j < skeleton.size(); ++j) {
    if (!skeleton[j].skins) continue;
    const std::int32_t parent = skinning_parent(skeleton, static_cast<std::int32_t>(j));
    if (parent < 0) continue;
    const auto p = static_cast<std::size_t>(parent);
    if ((place[j] - place[p]).norm() <= shortest) continue;
    leads_on[p] = 1;
    bones.push_back(
        {place[p], place[j], {parent, skinning_parent(skeleton, parent), static_cast<std::int32_t>(j)}});
  }
  for (std::size_t j = 0; j < skeleton.size(); ++j)
    if (skeleton[j].skins && !leads_on[j]) {
      const auto joint = static_cast<std::int32_t>(j);
      bones.push_back({place[j], place[j], {joint, skinning_parent(skeleton, joint), -1}});
    }
  return bones;
}

std::vector<Vector3d> points_along_bones(const std::vector<Bone>& bones, const scene::SurfaceMesh& surface,
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
        return (other - point).norm() < clearance * spacing;
      });
      if (!crowded && !search.is_nearer_than(point, clearance * spacing) && search.is_inside(point))
        points.push_back(point);
    }
  }
  return points;
}

}  // namespace fascicle::build
