// character.glb: the baked character with its looks and its skeleton's motion, but without its flesh. It is
// the source's glTF in one file, or a new document for a character made in code. The baked clip, sampled at
// every frame, comes before the source's clips. The bake's .glb is made from this file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "host/gltf/gltf_rig.h"
#include "host/model/model.h"
#include "host/rig/rig_math.h"
#include "host/scene/scene.h"

namespace fascicle::formats {

inline constexpr const char* character_name = "character.glb";

// The clip time that a frame shows, s.
using TimeOfFrame = std::function<double(std::uint64_t frame)>;

// Returns the file's contents, in metres: a scale of the scene becomes a node above all others. The names of
// missing images go into `missing`.
std::string character_glb(const scene::Scene& scene, const model::Model& model, const TimeOfFrame& time,
                          std::vector<std::string>& missing);

// The rig of a bake's character.glb. Throws SceneError if it cannot be read, and BakeError if its vertex
// count is not the model's.
gltf::Rig read_kept_rig(const std::filesystem::path& character, const model::Model& model);

// Whether a document's first animation is the clip that a bake was made with.
bool has_baked_clip(const nlohmann::json& document);

// Each joint's transform from its own space to the world in a frame, at the time stored in the file.
// `has_clip`: has_baked_clip of the rig's document; without it the skeleton is at rest.
std::vector<Eigen::Matrix4d> baked_joints(const gltf::Rig& rig, bool has_clip, std::uint64_t frame,
                                          double fps);

// The same in each joint's parent's space.
std::vector<rig::JointParts> baked_parts(const gltf::Rig& rig, bool has_clip, std::uint64_t frame,
                                         double fps);

// A document with only the render mesh at rest, for bodies that are not characters.
gltf::GltfDocument plain_document(const model::Model& model);

}  // namespace fascicle::formats
