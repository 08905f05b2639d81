#include "host/render/camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace fascicle::render {

namespace {

// Tangent of half the vertical angle of view: a long lens (about 85 mm on 35 mm film) keeps a body's
// proportions.
constexpr double half_height_tangent = 0.22;
// What a fitted picture leaves free on each side, as a fraction of its half width or height.
constexpr double margin = 0.10;

}  // namespace

Vector3d Camera::project(const Vector3d& world) const {
  const Vector3d p = axes * (world - eye);
  const double depth = -p.z();
  return {0.5 * width + focal * p.x() / depth, 0.5 * height - focal * p.y() / depth, depth};
}

Vector3d Camera::ray(double x, double y) const {
  return axes.transpose() * Vector3d((x - 0.5 * width) / focal, (0.5 * height - y) / focal, -1.0);
}

Matrix3d camera_axes(const View& view) {
  const double azimuth = view.azimuth * std::numbers::pi / 180.0;
  const double elevation = view.elevation * std::numbers::pi / 180.0;
  const Vector3d backward(std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                          std::cos(azimuth) * std::cos(elevation));
  const Vector3d right(std::cos(azimuth), 0.0, -std::sin(azimuth));
  Matrix3d axes;
  axes.row(0) = right;
  axes.row(1) = backward.cross(right);
  axes.row(2) = backward;
  return axes;
}

CameraFit::CameraFit(const View& view, unsigned width, unsigned height)
    : axes_(camera_axes(view)),
      width_(width),
      height_(height),
      tan_x_(half_height_tangent * (1.0 - margin) * width / height),
      tan_y_(half_height_tangent * (1.0 - margin)) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  right_ = top_ = nearest_ = -infinity;
  left_ = bottom_ = infinity;
}

void CameraFit::include(const Vector3d& point) {
  const Vector3d p = axes_ * point;
  right_ = std::max(right_, p.x() + tan_x_ * p.z());
  left_ = std::min(left_, p.x() - tan_x_ * p.z());
  top_ = std::max(top_, p.y() + tan_y_ * p.z());
  bottom_ = std::min(bottom_, p.y() - tan_y_ * p.z());
  nearest_ = std::max(nearest_, p.z());
}

Camera CameraFit::camera(double zoom) const {
  if (!(right_ >= left_ - 1e300)) throw std::logic_error("CameraFit: no point was included");
  // The eye at (x, y, z) sees p where |p.x - x| <= tan_x (z - p.z): x lies between right - tan z and left +
  // tan z.
  const double z = std::max({(right_ - left_) / (2.0 * tan_x_), (top_ - bottom_) / (2.0 * tan_y_),
                             nearest_ + 1e-3 * (1.0 + std::fabs(nearest_))});
  const Vector3d eye(0.5 * (right_ + left_), 0.5 * (top_ + bottom_), z);
  Camera camera;
  camera.eye = axes_.transpose() * eye;
  camera.axes = axes_;
  camera.focal = zoom * 0.5 * height_ / half_height_tangent;
  camera.width = width_;
  camera.height = height_;
  return camera;
}

}  // namespace fascicle::render
