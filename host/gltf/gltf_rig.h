// A glTF document to write out again, and skinning as glTF viewers do it.
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

// The whole file, checked as by read_gltf. Buffers and images move into `binary`, compressed geometry is
// decoded, weights get a sum of 1 (repair_weights), everything else stays. A missing image becomes a white
// pixel, and its name is appended to `missing`. Throws SceneError.
GltfDocument pack_gltf(const std::filesystem::path& path, std::vector<std::string>& missing,
                       const std::filesystem::path& converter = {});

// One primitive of one node, as in the file. A vertex is the sum of weight x
// joint_transform[skin_joint[slot]] x inverse_bind[slot] x position. An unskinned part has a single slot: the
// joint that carries it, and the transform from its node to that joint as `inverse_bind`.
struct RigPart {
  std::uint32_t node = 0, mesh = 0, primitive = 0;
  std::vector<Eigen::Vector3d> positions;
  std::vector<Eigen::Vector3d> normals;  // empty, or one per position
  // Where the material's base colour texture lies, v down: of the set that it names (without a texture
  // TEXCOORD_0), after its transform. Empty, or one per position.
  std::vector<Eigen::Vector2d> uvs;
  std::vector<std::uint32_t> skin_joint;  // per slot: index into Character::skeleton
  std::vector<Eigen::Matrix4d> inverse_bind;
  std::vector<std::uint32_t> influence_offset;  // vertices + 1
  std::vector<std::uint32_t> slot;
  std::vector<double> weight;
  std::vector<rig::BlendShape> shapes;  // morph targets; not applied to `positions`
  std::vector<double> rest_weights;     // per shape: the weight in the bind pose, where no clip animates it
};

// The weights of a part's shapes at `time` (s) of a clip; null clip: at rest.
std::vector<double> shape_weights(const RigPart& part, const rig::Clip* clip, double time);
// The part's positions with its shapes applied, before skinning.
std::vector<Eigen::Vector3d> shaped_positions(const RigPart& part, const rig::Clip* clip, double time);

// A character's parts, in the vertex order of Character::surface. Of `character`, only the skeleton, its root
// and its clips are filled.
struct Rig {
  rig::Character character;
  std::vector<std::uint32_t> joint_node;  // per joint: its node in the file
  std::vector<RigPart> parts;
};

// Reads any file that read_gltf can read. Throws SceneError.
Rig read_rig(const std::filesystem::path& path, const std::filesystem::path& converter = {},
             Still still = Still::left_out);

}  // namespace fascicle::gltf
