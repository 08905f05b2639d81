// What fascicle inspect --json prints.
#pragma once

#include <nlohmann/json.hpp>

#include "host/pipeline/build_scene.h"
#include "host/scene/scene.h"

namespace fascicle::cli {

// The contents of a scene and of what was built from it. Units are in the keys' names.
nlohmann::ordered_json inspect_json(const scene::Scene& scene, const pipeline::Built& built);

}  // namespace fascicle::cli
