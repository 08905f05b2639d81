// Selects the meshes of a glTF file that form the character, and the joints that carry them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "host/gltf/gltf.h"

namespace tinygltf {
class Model;
}

namespace fascicle::gltf {

// One primitive of one node: a mesh used by two nodes is two parts.
struct GltfPart {
  std::size_t node = 0, mesh = 0, primitive = 0;
  int skin = -1;     // -1: unskinned, it moves with its node
  int carrier = -1;  // unskinned parts: the nearest moving node, itself or above, that carries it
  Eigen::Matrix4d to_carrier = Eigen::Matrix4d::Identity();  // from node space to the carrier's space
};

struct GltfParts {
  std::vector<GltfPart> parts;     // in node order, then primitive order
  std::vector<int> skins;          // used by parts, ascending
  std::vector<int> carriers;       // of unskinned parts, ascending
  std::vector<std::string> notes;  // meshes that were left out, and why
};

// Finds the meshes of the default scene that have a skin, and the unskinned ones that are at or below a joint
// of such a skin, an animated node or a node with carries_mark. Leaves out meshes that nothing moves, and
// unskinned ones that are not triangles or are scaled to nothing at rest. If no mesh moves and `still` is
// Still::carried, the topmost nodes carry what is below them. Throws SceneError if the parts have more in all
// than is read of a file of this size (gltf_limits.h).
GltfParts find_parts(const std::filesystem::path& path, const tinygltf::Model& model,
                     const nlohmann::json& document, Still still);

// A node's transform in its parent's space.
Eigen::Matrix4d node_transform(const tinygltf::Model& model, std::size_t node);

// The parent of each node, -1 for roots.
std::vector<int> node_parents(const tinygltf::Model& model);

}  // namespace fascicle::gltf
