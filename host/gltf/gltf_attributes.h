// A primitive's attributes, checked against what glTF allows.
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

// The accessor's numbers. `pointer`: JSON pointer to the reference, for messages. `type`: the required type.
// `is_allowed`: whether its component type is allowed here. `count`: the required number of elements, 0 for
// any. Throws SceneError.
std::vector<double> attribute_numbers(const std::filesystem::path& path, const tinygltf::Model& model,
                                      const std::string& pointer, int accessor, int type, bool is_allowed,
                                      std::size_t count);

// Three numbers per vertex. Throws SceneError if the primitive has none.
std::vector<double> read_positions(const std::filesystem::path& path, const tinygltf::Model& model,
                                   const tinygltf::Primitive& primitive, const std::string& pointer);

// JOINTS_n and WEIGHTS_n, four of each per vertex. No weight is negative, and every weighted joint is in the
// skin.
struct InfluenceSet {
  std::vector<double> joints, weights;
};

// Set number `set` of a skinned primitive with `count` vertices, whose skin has `joints` joints; nullopt
// after the last set. Throws SceneError.
std::optional<InfluenceSet> read_influence_set(const std::filesystem::path& path,
                                               const tinygltf::Model& model,
                                               const tinygltf::Primitive& primitive,
                                               const std::string& pointer, int set, std::size_t count,
                                               std::size_t joints);

}  // namespace fascicle::gltf
