// Joins several glTF documents into one, each below its own node.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/gltf/gltf_rig.h"

namespace fascicle::formats {

// The nodes at the top of what is shown: those of the shown scene, or, in a document without scenes, all that
// are no node's child.
std::vector<std::size_t> shown_roots(const nlohmann::json& document);

// The new node above a part.
struct NodeAbove {
  std::string name;
  nlohmann::json transform;           // "translation" and "rotation", or "matrix"
  std::optional<std::size_t> parent;  // a node of the document; none: a root of the scene
};

// Adds the part's scene below a new node, with everything it needs. Prefixes node and clip names with NAME/
// unless they have that prefix. Drops extensions that refer to nodes by index (VRM bones, material variants,
// constraints). Returns the new node's index; node n of the part becomes that + 1 + n.
std::size_t add_document(gltf::GltfDocument& to, gltf::GltfDocument part, const NodeAbove& above);

}  // namespace fascicle::formats
