// What a page receives about a body before its first frame: docs/design/studio.md, "What the server sends at
// the start".
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/build/build.h"
#include "host/model/model.h"
#include "host/pipeline/messages.h"
#include "host/scene/scene.h"
#include "host/scene/scene_json.h"
#include "host/studio/server.h"

namespace fascicle::studio {

using scene::Json;

// The message of an array, and the array's name.
struct ArrayMessage {
  std::string name;
  SharedBytes bytes;
};

// A character's own colours, read once: materials and textures from its file.
struct BodyLooks {
  Json materials = Json::array(), textures = Json::array();
  std::vector<std::uint32_t> material;  // per render vertex, or empty
  std::vector<float> uvs, colours;      // 2 and 3 per vertex, or empty
  std::vector<SharedBytes> images;      // as stored in the file
};
// Empty if the file has no colours, or if its vertices do not match the model's surface. Warns about anything
// that cannot be read. `character`: a glTF file; empty: none.
BodyLooks read_body_looks(const std::filesystem::path& character, const model::Model& model,
                          const pipeline::Say& say);

// Per vertex, the joint of largest weight; empty without a skeleton.
std::vector<std::uint32_t> strongest_joints(const model::Model& model);

// The source of the messages. A bake has no report, and no scene if that can no longer be read.
struct BodyParts {
  const model::Model& model;
  const build::Report* report = nullptr;
  const scene::Scene* scene = nullptr;
};

// The arrays, all numbered with this body. An array that has not changed since `before` reuses that message.
std::vector<ArrayMessage> array_messages(const BodyParts& parts, const BodyLooks& looks, std::uint32_t body,
                                         const std::vector<ArrayMessage>& before);
// Only shape and layers, with names that begin with `prefix`.
std::vector<ArrayMessage> shape_messages(const model::Model& model, const std::string& prefix);
// Members shared by messages that describe a body.
Json layers_json(const model::Model& model);
Json counts_json(const model::Model& model);
// The message `body`.
Json body_json(const BodyParts& parts, const BodyLooks& looks, std::uint32_t body,
               const std::vector<ArrayMessage>& arrays);
// The message `clip`.
Json clip_json(const scene::Scene& scene, std::uint64_t frames, std::uint32_t substeps,
               std::uint32_t iterations);
// "list" of the message `warnings`.
Json warnings_json(const model::Model& model, const std::vector<build::Warning>& warnings);

// JSON as a message; invalid UTF-8 is replaced.
SharedBytes message_text(const Json& json);

}  // namespace fascicle::studio
