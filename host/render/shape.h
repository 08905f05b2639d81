// What is drawn: posed triangles in metres, Y up.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/render/image.h"
#include "host/render/looks.h"

namespace fascicle::render {

// How a shape responds to light. skin: softened towards red and with a sheen; plain: its colour times the
// light's strength, so that it matches a legend; painted: its own colour, with a sheen; ink: its colour,
// unlit.
enum class Finish { skin, plain, painted, ink };

struct Shape {
  std::vector<Vector3f> positions;  // m
  std::vector<Vector3f> normals;    // unit, one per position; ink needs none
  std::vector<Vector3f> colours;    // linear light, one per position
  std::vector<std::array<std::uint32_t, 3>> triangles;
  Finish finish = Finish::plain;
  bool blend_colours = true;  // false: each point takes the colour of its nearest corner, without
                              // interpolation
  bool draw_edges = false;    // thin dark lines along the triangles' edges
  bool casts_shadow = true;
  bool widens_shadows = true;   // false: shadow maps need not reach all of it, as of a floor
  std::vector<char> is_beside;  // one per position, or none: shadow maps need not reach it either
  // With looks, which must outlive the shape: their paints and textures multiply `colours`.
  const Looks* looks = nullptr;
  std::vector<std::uint32_t> paints;  // one per triangle
  std::vector<Vector2f> uvs;          // one per position, or none
};

}  // namespace fascicle::render
