// Where a picture is taken from.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "host/render/image.h"

namespace fascicle::render {

using Eigen::Matrix3d;

// Degrees. Azimuth 0 looks from +z towards the face of a glTF character, 90 from +x; elevation lifts the
// camera.
struct View {
  double azimuth = 0.0;
  double elevation = 0.0;
};

// A pinhole camera. In camera axes x is right, y up, and visible points have negative z.
struct Camera {
  Vector3d eye = Vector3d::Zero();       // m
  Matrix3d axes = Matrix3d::Identity();  // rows: right, up, backward
  double focal = 1.0;                    // pixels
  unsigned width = 1, height = 1;

  // Pixels from the left and top edge, then the distance in front of the camera (m).
  Vector3d project(const Vector3d& world) const;
  // Direction (not unit length) through a point of the picture.
  Vector3d ray(double x, double y) const;
};

Matrix3d camera_axes(const View& view);

// Fits the camera of a view around all points it was given, as closely as its margin allows. Exact in
// perspective: each side of the frame is a plane through the eye, and the four planes are moved out to the
// points.
class CameraFit {
 public:
  CameraFit(const View& view, unsigned width, unsigned height);
  void include(const Vector3d& point);
  // Needs at least one point. `zoom` 2 shows the middle half of the picture.
  Camera camera(double zoom = 1.0) const;

 private:
  Matrix3d axes_;
  unsigned width_, height_;
  double tan_x_, tan_y_;  // of half the angle of view, less the margin
  // Extremes of x + tan z and x - tan z over all points, and likewise for y; and the nearest point's z.
  double right_, left_, top_, bottom_, nearest_;
};

}  // namespace fascicle::render
