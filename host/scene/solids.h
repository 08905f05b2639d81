// The shapes of a scene's colliders as one kind of solid: a box whose edges are rounded, or a half space.
#pragma once

#include <Eigen/Core>

#include "host/scene/scene.h"

namespace fascicle::scene {

// In its own space the box lies around the origin, and of a half space everything below y = radius is solid.
// `axes` (a rotation) and `center` lead from there to the scene, metres. The radius holds the thickness.
struct Solid {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  Vector3d center = Vector3d::Zero();
  Vector3d half_size = Vector3d::Zero();  // before it is rounded
  double radius = 0.0;
  bool is_plane = false;
};

// As the scene says, before joints and keys move it.
Solid solid_of(const Collider& collider);

// The same, in the bind pose of the scene: what goes with a joint of one of several characters is said for
// that character's own.
Solid bound_solid_of(const Scene& scene, const Collider& collider);

// How far a point of the scene is from the solid, metres; below 0 inside.
double distance_to(const Solid& solid, const Vector3d& point);

// The rotation about an axis by its length in degrees. The same bits on every machine.
Eigen::Matrix3d turned_by(const Vector3d& degrees);

}  // namespace fascicle::scene
