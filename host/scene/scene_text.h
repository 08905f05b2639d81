// What a scene's text says.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "host/scene/scene.h"

namespace fascicle::scene {

// Its keys but scene.end, as "layers.fat.alpha", with their values as TOML in one line: comments, order and
// spelling are gone. Two scenes with the same keys are the same but for where they end and the order of their
// tables.
std::vector<std::pair<std::string, std::string>> keys_without_end(const Scene& scene);

}  // namespace fascicle::scene
