#include "host/scene/solids.h"

#include <cmath>

#include <Eigen/Geometry>

#include "host/base/trigonometry.h"

namespace fascicle::scene {

using Eigen::Matrix3d;

namespace {

// A rotation whose second axis points along `direction`.
Matrix3d upright_along(const Vector3d& direction) {
  // Scaled first, because squares of very small doubles underflow to 0.
  const Vector3d y = (direction / direction.cwiseAbs().maxCoeff()).normalized();
  Eigen::Index least = 0;
  y.cwiseAbs().minCoeff(&least);
  const Vector3d x = y.cross(Vector3d::Unit(least)).normalized();
  Matrix3d axes;
  axes << x, y, x.cross(y);
  return axes;
}

}  // namespace

Matrix3d turned_by(const Vector3d& degrees) {
  const double angle = degrees.norm() * (3.14159265358979323846 / 180.0);
  if (!(angle > 0.0)) return Matrix3d::Identity();
  const Vector3d n = degrees.normalized();
  const double s = base::exact_sin(angle), c = base::exact_cos(angle);
  Matrix3d cross;
  cross << 0.0, -n[2], n[1], n[2], 0.0, -n[0], -n[1], n[0], 0.0;
  return c * Matrix3d::Identity() + s * cross + (1.0 - c) * n * n.transpose();
}

Solid solid_of(const Collider& collider) {
  Solid solid;
  solid.center = collider.center;
  solid.radius = collider.radius + collider.thickness;
  switch (collider.shape) {
    case ColliderShape::plane:
      solid.is_plane = true;
      solid.axes = upright_along(collider.normal);
      break;
    case ColliderShape::sphere:
      break;
    case ColliderShape::capsule:
      solid.axes = upright_along(collider.to - collider.from);
      solid.center = (collider.from + collider.to) / 2.0;
      solid.half_size = {0.0, (collider.to - collider.from).norm() / 2.0, 0.0};
      break;
    case ColliderShape::box:
      solid.axes = turned_by(collider.rotation);
      solid.half_size = collider.size / 2.0 - Vector3d::Constant(collider.radius);
      break;
  }
  return solid;
}

Solid bound_solid_of(const Scene& scene, const Collider& collider) {
  Solid solid = solid_of(collider);
  if (scene.characters.empty() || collider.joint.empty()) return solid;
  const std::vector<rig::Joint>& skeleton = std::get<rig::Character>(scene.geometry).skeleton;
  for (std::size_t j = 0; j < skeleton.size(); ++j)
    if (skeleton[j].name == collider.joint)
      solid.center += scene.scale * scene.characters[character_of_joint(scene, j)].bind_offset;
  return solid;
}

double distance_to(const Solid& solid, const Vector3d& point) {
  const Vector3d p = solid.axes.transpose() * (point - solid.center);
  if (solid.is_plane) return p.y() - solid.radius;
  const Vector3d beyond = p.cwiseAbs() - solid.half_size;
  const double outside = beyond.cwiseMax(0.0).norm();
  return (outside > 0.0 ? outside : beyond.maxCoeff()) - solid.radius;
}

}  // namespace fascicle::scene
