// Attributes of a primitive, held against what glTF allows them to be.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace tinygltf {
class Model;
struct Primitive;
}  // namespace tinygltf

namespace fascicle::gltf {

// The accessor of an attribute, or -1.
int attribute_accessor(const tinygltf::Primitive& primitive, const std::string& name);

// The accessor's numbers; `pointer` leads to what names it, `type` is the one that it must have, and
// `is_allowed` says of the rest of its form. `count`: elements that it must have, or 0. Throws SceneError.
std::vector<double> attribute_numbers(const std::filesystem::path& path, const tinygltf::Model& model,
                                      const std::string& pointer, int accessor, int type, bool is_allowed,
                                      std::size_t count);

// Three a vertex. Throws SceneError where the primitive has none.
std::vector<double> read_positions(const std::filesystem::path& path, const tinygltf::Model& model,
                                   const tinygltf::Primitive& primitive, const std::string& pointer);

// JOINTS_n and WEIGHTS_n, four of each a vertex. No weight is negative, and what has weight is a joint of the
// skin.
struct InfluenceSet {
  std::vector<double> joints, weights;
};

// Nothing after the last set of a skinned primitive of `count` vertices, whose skin has `joints` joints.
// Throws SceneError.
std::optional<InfluenceSet> read_influence_set(const std::filesystem::path& path,
                                               const tinygltf::Model& model,
                                               const tinygltf::Primitive& primitive,
                                               const std::string& pointer, int set, std::size_t count,
                                               std::size_t joints);

}  // namespace fascicle::gltf
