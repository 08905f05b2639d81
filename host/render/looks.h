// What a surface is painted with: the colours and textures of its materials.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "host/render/image.h"

namespace fascicle::render {

using Eigen::Vector2f;
using Eigen::Vector4f;

// Outside 0 to 1 a texture repeats, repeats with every second copy mirrored, or continues its edge.
enum class Wrap { repeat, mirror, clamp };

// Red, green, blue (encoded as sRGB) and alpha, 0 to 255.
struct Texels {
  unsigned width = 0, height = 0;
  std::vector<std::uint8_t> values;  // 4 a texel, rows from the top
};

// A texture in linear light with its mip levels, each half as wide and high as the previous one.
class Texture {
 public:
  // Needs at least one texel. If it is wider or higher than `most`, only the levels that fit are kept.
  Texture(const Texels& texels, Wrap across, Wrap down, unsigned most = 8192);

  unsigned width() const { return levels_[0].width; }
  unsigned height() const { return levels_[0].height; }
  // The texels of the largest level kept.
  Texels texels() const;
  unsigned level_count() const { return static_cast<unsigned>(levels_.size()); }
  // The first level on which a pixel that covers `texels` texels of level 0 covers at most 2, or the last
  // level.
  unsigned level_for(float texels) const;
  // Interpolated between the four texels around `uv`, which is (0, 0) in the texture's upper left corner and
  // (1, 1) in its lower right. Red, green, blue in linear light, and alpha, 0 to 1.
  Vector4f at(const Vector2f& uv, unsigned level) const;

 private:
  struct Level {
    unsigned width = 0, height = 0;
    std::vector<std::uint16_t> values;  // 4 per texel, linear, 0 to 65535
  };
  static Level half_of(const Level& level);

  std::vector<Level> levels_;
  Wrap across_, down_;
};

struct Paint {
  Vector3f colour = Vector3f::Ones();  // linear light; multiplies the texture
  float alpha = 1.0f;                  // likewise
  float cutoff = 0.0f;                 // alpha below this makes a hole
  std::int32_t texture = -1;           // index; -1: none
};

// The looks of a surface of V vertices.
struct Looks {
  std::vector<Texture> textures;
  std::vector<Paint> paints;
  std::vector<std::uint32_t> paint_of_vertex;  // V; a triangle has the paint of its first corner
  std::vector<Vector2f> uvs;                   // V, or none
  std::vector<Vector3f> colours;               // V, linear light, multiplied with the paint; or none
};

}  // namespace fascicle::render
