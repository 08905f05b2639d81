// Studio light: every source is a handful of far lamps, each with a shadow map of its own, so that shadows
// are soft the way those of a wide source are.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/render/camera.h"
#include "host/render/shape.h"

namespace fascicle::render {

// Depth as seen along a direction, on a square that holds the shapes.
class ShadowMap {
 public:
  // `towards` points from the scene to the lamp, unit.
  ShadowMap(std::span<const Shape> shapes, const Vector3f& towards, const Vector3f& center, float radius,
            unsigned size);

  // Share of the lamp's light that reaches a point, 0 to 1, smoothed between texels. `normal` (unit) lifts
  // the point off the surface it lies on.
  float visibility(const Vector3f& point, const Vector3f& normal) const;

 private:
  bool is_lit(int x, int y, float height) const {
    return height >= height_[static_cast<std::size_t>(y) * static_cast<std::size_t>(size_) +
                             static_cast<std::size_t>(x)];
  }

  Vector3f right_, up_, towards_, center_;
  float scale_ = 1.0f, texel_ = 1.0f;  // texels a metre, metres a texel
  int size_ = 1;
  std::vector<float> height_;  // towards the lamp, of what is nearest to it
};

struct Lamp {
  Vector3f towards;     // unit
  Vector3f colour;      // irradiance on a surface that faces it
  bool shines = false;  // makes highlights
  ShadowMap shadow;
};

// Key from the upper left of the camera, weak fill from the right, rim from behind, and a dome for soft
// ambient shadow where surfaces meet. Turns with the camera.
std::vector<Lamp> studio_lamps(std::span<const Shape> shapes, const Camera& camera, unsigned threads);

// Light on a plain white surface facing `normal` at `point`.
Vector3f irradiance(std::span<const Lamp> lamps, const Vector3f& point, const Vector3f& normal);
// The same without anything in the way.
Vector3f free_irradiance(std::span<const Lamp> lamps, const Vector3f& normal);

}  // namespace fascicle::render
