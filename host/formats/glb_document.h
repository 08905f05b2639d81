// What morph targets change in the rest of a character's glTF document.
#pragma once

#include <cstddef>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/gltf/gltf_rig.h"

namespace fascicle::formats {

// Removes the weights of the morph targets of `meshes`: the baked clip's targets include their effect on the
// surface. Animations without channels are dropped, but not the first `kept`.
void drop_weight_channels(nlohmann::json& document, const std::vector<std::size_t>& meshes, std::size_t kept);

// Primitives of the meshes that the rig's nodes show, also those outside the rig.
std::size_t primitive_count(const nlohmann::json& document, const gltf::Rig& rig);
// A small file can share a mesh of many primitives among many nodes, whose copies take gigabytes.
inline constexpr std::size_t most_primitives = std::size_t{1} << 20u;

// The mesh of each part of the rig. If several nodes share a mesh, all but the first get a copy. Throws
// BakeError if there are more than most_primitives.
std::vector<std::size_t> own_meshes(nlohmann::json& document, const gltf::Rig& rig);

// All primitives of a mesh need the same number of targets: those outside the rig (lines) get `count` targets
// that move nothing. `meshes`: of the parts, from own_meshes().
void add_still_targets(nlohmann::json& document, const gltf::Rig& rig, const std::vector<std::size_t>& meshes,
                       std::size_t count);

}  // namespace fascicle::formats
