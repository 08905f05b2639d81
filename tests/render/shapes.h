// Bodies with closed forms, to be drawn.
#pragma once

#include "host/render/camera.h"
#include "host/render/shape.h"

namespace fascicle::tests {

// Around `center`, rings x 2 rings patches: with 128, nowhere farther inside than radius x (1 - cos(pi/256))
// twice, 1.5e-4 radius.
render::Shape sphere(const Eigen::Vector3f& center, float radius, const Eigen::Vector3f& colour,
                     std::uint32_t rings = 128);

// A square across an axis-aligned direction: center, half sides u and v; its normal is u x v.
render::Shape square(const Eigen::Vector3f& center, const Eigen::Vector3f& u, const Eigen::Vector3f& v,
                     const Eigen::Vector3f& colour);

// At (0, 0, distance), looking at the origin.
render::Camera camera_on_z(double distance, double focal, unsigned width, unsigned height);

}  // namespace fascicle::tests
