// The joints and clips of a glTF file.
#pragma once

#include <filesystem>
#include <vector>

#include <Eigen/Core>

#include "host/gltf/gltf_parts.h"
#include "host/rig/character.h"

namespace tinygltf {
class Model;
}

namespace fascicle::gltf {

// Fills the character's skeleton, root and clips. The skeleton has the joints of the parts' skins, the nodes
// that carry unskinned parts, and all nodes between and above them, except the topmost chain of nodes that
// are neither joints nor animated; that chain becomes Character::root. Returns each node's index in the
// skeleton, or -1. Inverse bind matrices are those of the rest pose until the skins are read. Throws
// SceneError for joints scaled to nothing and for keys out of order.
std::vector<std::int32_t> read_skeleton(const std::filesystem::path& path, const tinygltf::Model& model,
                                        const GltfParts& parts, rig::Character& character);

}  // namespace fascicle::gltf
