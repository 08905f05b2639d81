// Paint that is stored outside the character's file: values at some of its vertices, which override those in
// the file.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/rig/character.h"

namespace fascicle::rig {

// An attribute that can be painted.
struct PaintKind {
  const char* name = "";
  std::uint32_t width = 1;         // numbers per vertex
  double least = 0.0, most = 0.0;  // range of each number
  bool is_whole = false;
  bool is_direction = false;  // unit length, or 0: not painted
  double elsewhere = 0.0;     // used where neither a character's file nor the paint has a value
};
// _RIGID, _LAYER, _STIFFNESS, _FIBER.
std::span<const PaintKind> paint_kinds();
// Null if there is no kind of that name.
const PaintKind* find_paint_kind(std::string_view name);
// What meshes and characters have that lack an attribute which others have: its kind's `elsewhere`, or 0.
double value_elsewhere(std::string_view attribute);

// Single precision, as glTF stores them.
struct PaintedVertices {
  std::string name;                   // the name of a PaintKind
  std::vector<std::uint32_t> vertex;  // indices into the character's surface, ascending
  std::vector<float> value;           // the kind's width per vertex
};

struct Paint {
  std::string surface;                      // surface_hash of the painted surface
  std::uint64_t vertices = 0;               // its number of vertices
  std::vector<PaintedVertices> attributes;  // in the order of the kinds; none is empty
};

// Hashes positions and triangles; 32 hex digits.
std::string surface_hash(const mesh::SurfaceMesh& surface);

// Raises the numbers per vertex to `width`, if it has fewer: the new ones are 0, or 1 for the alpha of a
// COLOR_n.
void widen(PaintedAttribute& attribute, std::uint32_t width);

// Sets the values of the painted vertices. Adds an attribute that the character lacks, with the kind's
// `elsewhere` on all other vertices. The paint must belong to this surface. Throws base::SceneError if the
// character has an attribute of the same name with another width.
void lay_over(const Paint& paint, Character& character);

}  // namespace fascicle::rig
