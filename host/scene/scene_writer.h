// A parsed scene as the text of a scene file.
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/scene/toml.h"

namespace fascicle::scene {

// The scene file that reads as `root` does: same values, same order of layers. `root` has passed check_scene.
std::string write_scene(const toml::table& root);

// The same with all keys that the scene leaves at their defaults, as comments to be uncommented, and what
// each key means: from the table of keys, but for keys and tables of the names left out.
std::string write_documented_scene(const toml::table& root, std::span<const char* const> left_out);

// Each key with the names of its tables before it, parted by dots, and its value in one line.
std::vector<std::pair<std::string, std::string>> keys_and_values(const toml::table& root);

}  // namespace fascicle::scene
