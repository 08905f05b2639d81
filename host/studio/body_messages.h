// What a page is sent of a body before it sees a frame: docs/design/studio.md, "What the server sends at the
// start".
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

// A message of an array, by the array's name.
struct ArrayMessage {
  std::string name;
  SharedBytes bytes;
};

// A character's own colours, read once: materials and textures as its file has them.
struct BodyLooks {
  Json materials = Json::array(), textures = Json::array();
  std::vector<std::uint32_t> material;  // of each vertex of the render mesh, or empty
  std::vector<float> uvs, colours;      // 2 and 3 a vertex, or empty
  std::vector<SharedBytes> images;      // as they lie in the file
};
// Empty where the file has no colours, or its vertices are not those of the model's surface. What could not
// be read is said. `character`: a glTF file; empty: none.
BodyLooks read_body_looks(const std::filesystem::path& character, const model::Model& model,
                          const pipeline::Say& say);

// Of each vertex the joint that it follows most; empty without a skeleton.
std::vector<std::uint32_t> strongest_joints(const model::Model& model);

// What the messages are made from. A bake has no report, and no scene where that cannot be read any more.
struct BodyParts {
  const model::Model& model;
  const build::Report* report = nullptr;
  const scene::Scene* scene = nullptr;
};

// The arrays, all numbered with this body. One whose items are those of `before` is that message itself.
std::vector<ArrayMessage> array_messages(const BodyParts& parts, const BodyLooks& looks, std::uint32_t body,
                                         const std::vector<ArrayMessage>& before);
// Shape and layers alone, under names that begin with `prefix`.
std::vector<ArrayMessage> shape_messages(const model::Model& model, const std::string& prefix);
// Members of messages that describe a body.
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

// JSON as a message; text that is not UTF-8 is made so.
SharedBytes message_text(const Json& json);

}  // namespace fascicle::studio
