// Several glTF documents as one, each below a node of its own.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "host/gltf/gltf_rig.h"

namespace fascicle::formats {

// Where the node stands that is made above a part.
struct NodeAbove {
  std::string name;
  nlohmann::json transform;           // "translation" and "rotation", or "matrix"
  std::optional<std::size_t> parent;  // a node of the document; none: the scene shows it
};

// Adds what the part's scene shows below a new node, with all that it needs; nodes and clips are called
// NAME/... from now on, if they are not yet. What names nodes by number outside the format's core
// (VRM's bones, variants of materials, constraints) is left out. Returns the new node's number; node n of the
// part has become that + 1 + n.
std::size_t add_document(gltf::GltfDocument& to, gltf::GltfDocument part, const NodeAbove& above);

}  // namespace fascicle::formats
