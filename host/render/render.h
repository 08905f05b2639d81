// Renders shapes with a camera and light. Software rendering, so that it needs no display, driver or GPU; the
// same bytes for any number of threads.
#pragma once

#include <optional>
#include <span>

#include "host/render/camera.h"
#include "host/render/image.h"
#include "host/render/shape.h"

namespace fascicle::render {

struct Backdrop {
  std::optional<double> ground;       // height of a floor that receives shadows (m)
  Vector3f top{0.60f, 0.63f, 0.66f};  // linear light, at the picture's upper and lower edge
  Vector3f bottom{0.80f, 0.80f, 0.79f};
};

// Triangles that reach behind the camera are left out.
Image render(std::span<const Shape> shapes, const Camera& camera, const Backdrop& backdrop = {},
             unsigned threads = 0);

// What is at the centre of each pixel: the triangle (counted through all shapes; no_triangle for none) and
// the distance along the camera's axis (m). For tests and tools: these are the surfaces that render() shades.
inline constexpr std::uint32_t no_triangle = 0xffffffffu;
struct DepthImage {
  unsigned width = 0, height = 0;
  std::vector<std::uint32_t> triangle;
  std::vector<float> depth;  // 0 where there is none
};
DepthImage render_depth(std::span<const Shape> shapes, const Camera& camera, unsigned threads = 0);

}  // namespace fascicle::render
