// A picture in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace fascicle::render {

using Eigen::Vector3d;
using Eigen::Vector3f;

// Red, green, blue, 0 to 255, encoded as sRGB.
struct Image {
  unsigned width = 0, height = 0;
  std::vector<std::uint8_t> pixels;  // 3 per pixel, rows from the top

  Image() = default;
  Image(unsigned w, unsigned h) : width(w), height(h), pixels(std::size_t{3} * w * h) {}
  std::uint8_t* at(unsigned x, unsigned y) { return &pixels[3 * (std::size_t{y} * width + x)]; }
  const std::uint8_t* at(unsigned x, unsigned y) const { return &pixels[3 * (std::size_t{y} * width + x)]; }
};

}  // namespace fascicle::render
