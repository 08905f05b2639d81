// character.glb: the character of a bake with its looks and its skeleton's motion, without its flesh. The
// source's glTF as it is, in one file, or a new one for a character made in code; the baked clip, sampled at
// every frame, stands before the source's clips. The .glb of the bake is made from it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "host/gltf/gltf_rig.h"
#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::formats {

inline constexpr const char* character_name = "character.glb";

// Of each joint, from its own space to the world (metres of the file), at the end of a frame.
using PoseOfFrame = std::function<std::vector<Eigen::Matrix4d>(std::uint64_t frame)>;

// The clip's time that a frame shows, s.
using TimeOfFrame = std::function<double(std::uint64_t frame)>;

// Its bytes. Metres: a scale of the scene becomes a node above all others. `missing` gets the names of images
// that are not there.
std::string character_glb(const scene::Scene& scene, const model::Model& model, const PoseOfFrame& pose,
                          const TimeOfFrame& time, std::vector<std::string>& missing);

// The rig of a bake's character.glb. Throws SceneError where it cannot be read and BakeError where it has not
// the model's render vertices.
gltf::Rig read_kept_rig(const std::filesystem::path& character, const model::Model& model);

// Whether the first animation of a document is the clip that a bake was made with.
bool has_baked_clip(const nlohmann::json& document);

// Each joint's map from its own space to the world in a frame, at the time that the file has for it.
// `has_clip`: has_baked_clip of the rig's document; without it the skeleton rests.
std::vector<Eigen::Matrix4d> baked_joints(const gltf::Rig& rig, bool has_clip, std::uint64_t frame,
                                          double fps);

// A document with the render mesh at rest and nothing else, for bodies that are no characters.
gltf::GltfDocument plain_document(const model::Model& model);

}  // namespace fascicle::formats
