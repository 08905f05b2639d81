// The morph targets of a glTF file.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/rig/blend_shapes.h"

namespace tinygltf {
class Model;
struct Primitive;
}  // namespace tinygltf

namespace fascicle::gltf {

using Eigen::Vector3d;

// Positions that the targets of one file may have in all, moved or not.
inline constexpr std::size_t most_target_positions = std::size_t{1} << 27;

// The primitive's targets, in their order; a target without positions moves nothing. `count`: of the
// primitive's vertices; `pointer` leads to it. Takes from `left` what it reads. Throws SceneError.
std::vector<rig::BlendShape> read_shapes(const std::filesystem::path& path, const tinygltf::Model& model,
                                         const tinygltf::Primitive& primitive, const std::string& pointer,
                                         std::size_t count, std::size_t& left);

// The weights of a node's shapes where no clip moves them: the node's own, its mesh's or 0. `document` as in
// the file, checked.
std::vector<double> rest_weights(const nlohmann::json& document, std::size_t node, std::size_t mesh,
                                 std::size_t shapes);

// Adds the shapes' moves, each times its weight, to positions.
void add_shapes(const std::vector<rig::BlendShape>& shapes, const std::vector<double>& weights,
                std::vector<Vector3d>& positions);

}  // namespace fascicle::gltf
