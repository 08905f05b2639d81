// glTF as a document to hand on, and how its viewers move a skinned vertex.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "host/gltf/gltf.h"
#include "host/rig/blend_shapes.h"
#include "host/rig/character.h"

namespace fascicle::gltf {

// A glTF document with one buffer.
struct GltfDocument {
  nlohmann::json json;
  std::string binary;
};

// The whole file, checked as read_gltf does; buffers and images inside `binary`, compressed geometry made
// plain, all else as it is. An image
// that is not there becomes a white pixel, and its name is appended to `missing`. Throws SceneError.
GltfDocument pack_gltf(const std::filesystem::path& path, std::vector<std::string>& missing,
                       const std::filesystem::path& converter = {});

// One primitive of one node as the file holds it: a vertex stands at the sum of
// weight x joint_transform[skin_joint[slot]] x inverse_bind[slot] x position. A hung one has a single slot:
// the joint that carries it, and the way from its node to that joint as `inverse_bind`.
struct RigPart {
  std::uint32_t node = 0, mesh = 0, primitive = 0;
  std::vector<Eigen::Vector3d> positions;
  std::vector<Eigen::Vector3d> normals;   // none, or one a position
  std::vector<Eigen::Vector2d> uvs;       // TEXCOORD_0, as in the file (v down): none, or one a position
  std::vector<std::uint32_t> skin_joint;  // of a slot: index into Character::skeleton
  std::vector<Eigen::Matrix4d> inverse_bind;
  std::vector<std::uint32_t> influence_offset;  // vertices + 1
  std::vector<std::uint32_t> slot;
  std::vector<double> weight;
  std::vector<rig::BlendShape> shapes;  // morph targets; `positions` are without them
  std::vector<double> rest_weights;     // of each shape, where no clip moves it: in the bind pose
};

// The weights of a part's shapes at `time` (s) of a clip; null: at rest.
std::vector<double> shape_weights(const RigPart& part, const rig::Clip* clip, double time);
// The part's positions with its shapes, as its skin finds them.
std::vector<Eigen::Vector3d> shaped_positions(const RigPart& part, const rig::Clip* clip, double time);

// The parts of a character in the order of Character::surface's vertices; of `character`, the skeleton, its
// root and its clips.
struct Rig {
  rig::Character character;
  std::vector<std::uint32_t> joint_node;  // of a joint: its node in the file
  std::vector<RigPart> parts;
};

// Of a file that read_gltf can read. Throws SceneError.
Rig read_rig(const std::filesystem::path& path, const std::filesystem::path& converter = {},
             Still still = Still::left_out);

}  // namespace fascicle::gltf
