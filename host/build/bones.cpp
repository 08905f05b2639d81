#include "host/build/bones.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "host/build/message.h"
#include "host/build/where.h"

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

// Whether the ray from `origin` along `direction` meets the triangle (Moeller and Trumbore, 1997).
bool ray_meets(const Vector3d& origin, const Vector3d& direction, const Vector3d& a, const Vector3d& b,
               const Vector3d& c) {
  const Vector3d ab = b - a, ac = c - a;
  const Vector3d across = direction.cross(ac);
  const double determinant = ab.dot(across);
  if (determinant == 0.0) return false;
  const Vector3d from_a = origin - a;
  const double u = from_a.dot(across) / determinant;
  const Vector3d q = from_a.cross(ab);
  const double v = direction.dot(q) / determinant;
  return u >= 0.0 && v >= 0.0 && u + v <= 1.0 && ac.dot(q) / determinant > 0.0;
}

bool is_clear_of_surface(const scene::SurfaceMesh& surface, const Vector3d& point, double distance) {
  return std::all_of(surface.triangles.begin(), surface.triangles.end(), [&](const auto& t) {
    return triangle_distance(point, surface.vertices[t[0]], surface.vertices[t[1]], surface.vertices[t[2]]) >=
           distance;
  });
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
      if (!crowded && is_clear_of_surface(surface, point, clearance * spacing) && is_inside(surface, point))
        points.push_back(point);
    }
  }
  return points;
}

bool is_inside(const scene::SurfaceMesh& surface, const Vector3d& point) {
  // No plane or edge that an artist would draw lies along these.
  const std::array<Vector3d, 3> directions{
      Vector3d(0.8147, 0.4271, 0.3923), Vector3d(-0.3719, 0.6343, 0.6778), Vector3d(0.2137, -0.5839, 0.7832)};
  int inside = 0;
  for (const Vector3d& direction : directions) {
    const auto crossings =
        std::count_if(surface.triangles.begin(), surface.triangles.end(), [&](const auto& t) {
          return ray_meets(point, direction, surface.vertices[t[0]], surface.vertices[t[1]],
                           surface.vertices[t[2]]);
        });
    inside += crossings % 2 == 1 ? 1 : 0;
  }
  return inside >= 2;
}

double triangle_distance(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const double to_sides =
      std::min({segment_distance(p, a, b), segment_distance(p, b, c), segment_distance(p, c, a)});
  const Vector3d normal = (b - a).cross(c - a);
  const bool above = (b - a).cross(p - a).dot(normal) >= 0.0 && (c - b).cross(p - b).dot(normal) >= 0.0 &&
                     (a - c).cross(p - c).dot(normal) >= 0.0;
  const double area = normal.norm();
  if (!above || !(area > 0.0)) return to_sides;
  return std::min(to_sides, std::abs((p - a).dot(normal)) / area);
}

}  // namespace fascicle::build
