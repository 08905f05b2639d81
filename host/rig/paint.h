// What is painted on a character beside its own file: values at some of its vertices, which go before those
// that the file has there.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/rig/character.h"

namespace fascicle::rig {

// An attribute that can be painted so.
struct PaintKind {
  const char* name = "";
  std::uint32_t width = 1;         // numbers a vertex
  double least = 0.0, most = 0.0;  // of each number
  bool is_whole = false;
  bool is_direction = false;  // of length 1, or 0: not painted
  double elsewhere = 0.0;     // where neither the character's file nor this paint has a value
};
// _RIGID, _LAYER, _STIFFNESS, _FIBER.
std::span<const PaintKind> paint_kinds();
// Null where there is none of that name.
const PaintKind* find_paint_kind(std::string_view name);

// Single precision, as glTF stores them.
struct PaintedVertices {
  std::string name;                   // of a PaintKind
  std::vector<std::uint32_t> vertex;  // of the character's surface, ascending
  std::vector<float> value;           // the kind's width each
};

struct Paint {
  std::string surface;                      // surface_hash of what it is painted on
  std::uint64_t vertices = 0;               // that this has
  std::vector<PaintedVertices> attributes;  // in the order of the kinds; none is empty
};

// Of positions and triangles; 32 hex digits.
std::string surface_hash(const mesh::SurfaceMesh& surface);

// Sets the values of the painted vertices. An attribute that the character lacks is made, with the kind's
// `elsewhere` on all other vertices. The paint is of this surface. Throws base::SceneError where the
// character has an attribute of such a name and another width.
void lay_over(const Paint& paint, Character& character);

}  // namespace fascicle::rig
