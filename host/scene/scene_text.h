// The content of a scene's text.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "host/scene/scene.h"

namespace fascicle::scene {

// Its keys except scene.end, as "layers.fat.alpha", with their values as one line of TOML; comments, order
// and spelling are dropped. Scenes with equal keys differ at most in their end and the order of their tables.
std::vector<std::pair<std::string, std::string>> keys_without_end(const Scene& scene);

}  // namespace fascicle::scene
