// Which meshes of a glTF file are the character, and which joints carry them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "host/gltf/gltf.h"

namespace tinygltf {
class Model;
}

namespace fascicle::gltf {

// One primitive shown by one node: a mesh that two nodes show is two parts.
struct GltfPart {
  std::size_t node = 0, mesh = 0, primitive = 0;
  int skin = -1;     // -1: hung, it moves as its node does
  int carrier = -1;  // of a hung part: the node that carries it, itself or the nearest above it that moves
  Eigen::Matrix4d to_carrier = Eigen::Matrix4d::Identity();  // from the node's space to its carrier's
};

struct GltfParts {
  std::vector<GltfPart> parts;     // in the order of the nodes, then of the primitives
  std::vector<int> skins;          // that parts have, ascending
  std::vector<int> carriers;       // of hung parts, ascending
  std::vector<std::string> notes;  // meshes of the scene that are left out, and why
};

// The meshes of the default scene that have a skin, and those without one that stand on or below a joint of
// such a skin, a node that a clip moves or one that the document marks (carries_mark). The rest is left out:
// what nothing moves, and what is hung and no triangles, or scaled to nothing at rest. Where that would be
// all and Still says so, the topmost nodes carry what is below them.
GltfParts find_parts(const tinygltf::Model& model, const nlohmann::json& document, Still still);

// A node's transform in its parent's space.
Eigen::Matrix4d node_transform(const tinygltf::Model& model, std::size_t node);

// Parent of each node, -1 for roots.
std::vector<int> node_parents(const tinygltf::Model& model);

}  // namespace fascicle::gltf
