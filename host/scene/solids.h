// Represents all shapes of a scene's colliders as one kind of solid: a rounded box, or a half space.
#pragma once

#include <Eigen/Core>

#include "host/scene/scene.h"

namespace fascicle::scene {

// In its own space, a box is centred at the origin, and a half space is solid below y = radius. `axes` (a
// rotation) and `center` map from there to the scene, in metres. The radius includes the thickness.
struct Solid {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  Vector3d center = Vector3d::Zero();
  Vector3d half_size = Vector3d::Zero();  // before rounding
  double radius = 0.0;
  bool is_plane = false;
};

// As given in the scene, before joints and keys move it.
Solid solid_of(const Collider& collider);

// The same, in the scene's bind pose. A collider attached to a joint of one of several characters is given in
// that character's own bind pose.
Solid bound_solid_of(const Scene& scene, const Collider& collider);

// Signed distance in metres of a point of the scene from the solid; negative inside.
double distance_to(const Solid& solid, const Vector3d& point);

// Rotation about the direction of `degrees` by its length. Bit-identical on every machine.
Eigen::Matrix3d turned_by(const Vector3d& degrees);

}  // namespace fascicle::scene
