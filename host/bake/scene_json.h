// JSON as manifests and checkpoints have it. A scene's parameters: host/scene/scene_json.h.
#pragma once

#include <string>

#include "host/scene/scene_json.h"

namespace fascicle::bake {

using scene::Json;
using scene::json_of;

// As text; bytes that are not UTF-8 (in file names) become U+FFFD. indent < 0: one line.
std::string dump(const Json& json, int indent = -1);

}  // namespace fascicle::bake
