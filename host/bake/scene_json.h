// A scene's parameters as JSON, for the manifest.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/scene/scene.h"

namespace fascicle::bake {

using Json = nlohmann::ordered_json;

// As text; bytes that are not UTF-8 (in file names) become U+FFFD. indent < 0: one line.
std::string dump(const Json& json, int indent = -1);

Json json_of(const scene::Vector3d& vector);
Json json_of(const scene::Where& where);
Json json_of(const std::vector<scene::Force>& forces);
Json json_of(const scene::Motion& motion);
// Every parameter; of meshes and clips, which the input hashes stand for, the counts.
Json json_of(const scene::Scene& scene);

}  // namespace fascicle::bake
