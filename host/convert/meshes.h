// Meshes and their skins.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/convert/character.h"
#include "host/convert/document.h"

namespace fascicle::convert {

struct PlacedMesh {
  std::size_t mesh = 0;
  std::optional<std::size_t> skin;
};

// A node's mesh in glTF: a primitive for each of its meshes that has triangles, including seams; nothing if
// none has. Vertices of a skinned mesh without bones follow the node itself.
std::optional<PlacedMesh> add_mesh(Character& character, std::size_t node, Document& document);

}  // namespace fascicle::convert
