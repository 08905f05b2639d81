#include "tests/render/shapes.h"

#include <cmath>
#include <numbers>

namespace fascicle::tests {

render::Shape sphere(const Eigen::Vector3f& center, float radius, const Eigen::Vector3f& colour,
                     std::uint32_t rings) {
  const std::uint32_t columns = 2 * rings;
  render::Shape shape;
  for (std::uint32_t i = 0; i <= rings; ++i)
    for (std::uint32_t j = 0; j < columns; ++j) {
      const double a = std::numbers::pi * i / rings, b = 2.0 * std::numbers::pi * j / columns;
      const Eigen::Vector3f n =
          Eigen::Vector3d(std::sin(a) * std::cos(b), std::cos(a), std::sin(a) * std::sin(b)).cast<float>();
      shape.positions.push_back(center + radius * n);
      shape.normals.push_back(n);
      shape.colours.push_back(colour);
    }
  for (std::uint32_t i = 0; i < rings; ++i)
    for (std::uint32_t j = 0; j < columns; ++j) {
      const std::uint32_t a = i * columns + j, b = i * columns + (j + 1) % columns;
      shape.triangles.push_back({a, b, b + columns});
      shape.triangles.push_back({a, b + columns, a + columns});
    }
  return shape;
}

render::Shape square(const Eigen::Vector3f& center, const Eigen::Vector3f& u, const Eigen::Vector3f& v,
                     const Eigen::Vector3f& colour) {
  render::Shape shape;
  shape.positions = {center - u - v, center + u - v, center + u + v, center - u + v};
  shape.normals.assign(4, u.cross(v).normalized());
  shape.colours.assign(4, colour);
  shape.triangles = {{0, 1, 2}, {0, 2, 3}};
  return shape;
}

render::Camera camera_on_z(double distance, double focal, unsigned width, unsigned height) {
  render::Camera camera;
  camera.eye = {0.0, 0.0, distance};
  camera.focal = focal;
  camera.width = width;
  camera.height = height;
  return camera;
}

}  // namespace fascicle::tests
