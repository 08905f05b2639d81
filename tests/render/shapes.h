// Shapes with closed forms, for drawing.
#pragma once

#include "host/render/camera.h"
#include "host/render/shape.h"

namespace fascicle::tests {

// A sphere of rings x 2 rings patches around `center`: with 128, nowhere further inside than twice radius x
// (1 - cos(pi/256)), 1.5e-4 radius.
render::Shape sphere(const Eigen::Vector3f& center, float radius, const Eigen::Vector3f& colour,
                     std::uint32_t rings = 128);

// A square perpendicular to an axis: its centre and half sides u and v; its normal is u x v.
render::Shape square(const Eigen::Vector3f& center, const Eigen::Vector3f& u, const Eigen::Vector3f& v,
                     const Eigen::Vector3f& colour);

// A camera at (0, 0, distance), looking at the origin.
render::Camera camera_on_z(double distance, double focal, unsigned width, unsigned height);

}  // namespace fascicle::tests
