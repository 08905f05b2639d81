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

// How much is read of a file's targets: positions of all of them, moved or not, and moved ones, which are
// kept. The latter depends on the file's size, because many targets may name one accessor.
struct ShapeLimits {
  explicit ShapeLimits(const tinygltf::Model& model);

  std::size_t most_positions, most_moved;
  std::size_t positions = 0, moved = 0;  // so far
};

// The primitive's targets, in order; a target without positions moves nothing. `count`: vertices of the
// primitive. `pointer`: its JSON pointer. Adds to `limits`. Throws SceneError.
std::vector<rig::BlendShape> read_shapes(const std::filesystem::path& path, const tinygltf::Model& model,
                                         const tinygltf::Primitive& primitive, const std::string& pointer,
                                         std::size_t count, ShapeLimits& limits);

// The weights of a node's shapes where no clip animates them: the node's, else its mesh's, else 0.
// `document`: the file's, checked.
std::vector<double> rest_weights(const nlohmann::json& document, std::size_t node, std::size_t mesh,
                                 std::size_t shapes);

// Adds each shape's offsets, times its weight, to positions.
void add_shapes(const std::vector<rig::BlendShape>& shapes, const std::vector<double>& weights,
                std::vector<Vector3d>& positions);

}  // namespace fascicle::gltf
