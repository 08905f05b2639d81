// Studio light: every source is a handful of distant lamps, each with a shadow map, which gives the soft
// shadows of a wide source.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "host/render/camera.h"
#include "host/render/shape.h"

namespace fascicle::render {

// Depth along a direction, on a square that covers the shapes.
class ShadowMap {
 public:
  // `towards` points from the scene to the lamp, unit.
  ShadowMap(std::span<const Shape> shapes, const Vector3f& towards, const Vector3f& center, float radius,
            unsigned size);

  // Fraction of the lamp's light that reaches a point, 0 to 1, interpolated between texels. `normal` (unit)
  // offsets the point from the surface it is on.
  float visibility(const Vector3f& point, const Vector3f& normal) const;

  enum class Seen { whole, none, unknown };
  // Of all points of a flat convex patch with these corners and one normal. `whole`: the visibility of each
  // is 1, up to rounding; `none`: it is 0.
  Seen seen_of_patch(const std::array<Vector3f, 4>& corners, const Vector3f& normal) const;

 private:
  struct Place {
    float x, y, height;  // texels from the centre of the first one, metres towards the lamp
  };
  Place place_of(const Vector3f& point, const Vector3f& normal) const;

  bool is_lit(int x, int y, float height) const {
    return height >= height_[static_cast<std::size_t>(y) * static_cast<std::size_t>(size_) +
                             static_cast<std::size_t>(x)];
  }

  // Of a block of texels: most points are above or below all of it, and then one block is read instead of
  // four texels far apart in memory.
  struct Heights {
    float least, most;
  };
  const Heights& block_of(int x, int y) const {
    return blocks_[static_cast<std::size_t>(y >> block_bits) * blocks_in_row_ +
                   static_cast<std::size_t>(x >> block_bits)];
  }
  void find_blocks();

  static constexpr int block_bits = 3;

  Vector3f right_, up_, towards_, center_;
  float scale_ = 1.0f, texel_ = 1.0f;  // texels per metre, metres per texel
  int size_ = 1;
  std::vector<float> height_;  // height towards the lamp of the surface nearest to it
  // Each of a square of 2^block_bits texels and of the next row and column after it.
  std::vector<Heights> blocks_;
  std::size_t blocks_in_row_ = 1;
};

struct Lamp {
  Vector3f towards;     // unit
  Vector3f colour;      // irradiance on a surface that faces it
  bool shines = false;  // makes highlights
  ShadowMap shadow;
};

// Key light from the upper left of the camera, weak fill from the right, rim light from behind, and a dome
// for soft ambient shadow where surfaces meet. Turns with the camera.
std::vector<Lamp> studio_lamps(std::span<const Shape> shapes, const Camera& camera, unsigned threads);

// Irradiance of a plain white surface facing `normal` at `point`.
Vector3f irradiance(std::span<const Lamp> lamps, const Vector3f& point, const Vector3f& normal);

// The light of a patch of the floor: most patches are lit wholly, or not at all, by all but a few lamps.
struct PatchLight {
  Vector3f whole;                      // irradiance from the lamps that light all of it
  std::vector<std::uint32_t> unknown;  // lamps of which every point must be asked
};
PatchLight light_of_patch(std::span<const Lamp> lamps, const std::array<Vector3f, 4>& corners,
                          const Vector3f& normal);
// What `irradiance` gives at a point of the patch, up to rounding.
Vector3f irradiance(std::span<const Lamp> lamps, const PatchLight& patch, const Vector3f& point,
                    const Vector3f& normal);

// The same without occlusion.
Vector3f free_irradiance(std::span<const Lamp> lamps, const Vector3f& normal);

}  // namespace fascicle::render
