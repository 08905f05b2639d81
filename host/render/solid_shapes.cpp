#include "host/render/solid_shapes.h"

#include <cmath>

namespace fascicle::render {

namespace {

using Eigen::Vector3d;

constexpr int steps_of_quarter = 12;
const Vector3f solid_colour{0.33f, 0.36f, 0.40f};

void append(Shape& shape, const DrawnSolid& solid, const Vector3d& place, const Vector3d& normal) {
  shape.positions.push_back((solid.center + solid.axes * place).cast<float>());
  shape.normals.push_back((solid.axes * normal).cast<float>());
  shape.colours.push_back(solid_colour);
}

void append_quad(Shape& shape, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  shape.triangles.push_back({a, b, c});
  shape.triangles.push_back({a, c, d});
}

// Directions around the middle: a quarter circle between each two corners of the box, so that the box's faces
// are the strips between quarters.
struct Direction {
  double angle;
  double sign;  // of the half sizes that are added
};

}  // namespace

Shape solid_shape(const DrawnSolid& solid, const Vector3d& middle, double reach) {
  Shape shape;
  shape.finish = Finish::plain;
  if (solid.is_plane) {
    Vector3d around = solid.axes.transpose() * (middle - solid.center);
    around.y() = solid.radius;
    for (const auto& [x, z] : {std::pair{-1, -1}, {-1, 1}, {1, 1}, {1, -1}})
      append(shape, solid, around + reach * Vector3d(x, 0, z), Vector3d::UnitY());
    append_quad(shape, 0, 1, 2, 3);
    shape.casts_shadow = false;
    return shape;
  }
  const double quarter = std::acos(0.0);
  std::vector<Direction> rows;
  for (const double half : {1.0, -1.0})
    for (int k = 0; k <= steps_of_quarter; ++k)
      rows.push_back(
          {half * quarter * (half > 0.0 ? 1.0 - double(k) / steps_of_quarter : double(k) / steps_of_quarter),
           half});
  constexpr std::uint32_t columns = 4 * (steps_of_quarter + 1);
  const double sign_x[] = {1.0, -1.0, -1.0, 1.0}, sign_z[] = {1.0, 1.0, -1.0, -1.0};
  for (const Direction& row : rows)
    for (std::uint32_t c = 0; c < columns; ++c) {
      const std::uint32_t part = c / (steps_of_quarter + 1);
      const double turn = quarter * (part + double(c % (steps_of_quarter + 1)) / steps_of_quarter);
      const Vector3d normal(std::cos(row.angle) * std::cos(turn), std::sin(row.angle),
                            std::cos(row.angle) * std::sin(turn));
      const Vector3d corner(sign_x[part] * solid.half_size.x(), row.sign * solid.half_size.y(),
                            sign_z[part] * solid.half_size.z());
      append(shape, solid, corner + solid.radius * normal, normal);
    }
  const auto last = static_cast<std::uint32_t>(rows.size()) - 1;
  for (std::uint32_t r = 0; r < last; ++r)
    for (std::uint32_t c = 0; c < columns; ++c) {
      const std::uint32_t next = (c + 1) % columns;
      append_quad(shape, r * columns + c, r * columns + next, (r + 1) * columns + next,
                  (r + 1) * columns + c);
    }
  // The top and the bottom face.
  const std::uint32_t corner = steps_of_quarter + 1;
  append_quad(shape, 0, 3 * corner, 2 * corner, corner);
  append_quad(shape, last * columns, last * columns + corner, last * columns + 2 * corner,
              last * columns + 3 * corner);
  return shape;
}

}  // namespace fascicle::render
