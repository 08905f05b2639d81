// A parsed scene as the text of a scene file.
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/scene/toml.h"

namespace fascicle::scene {

// A scene file that parses to `root`: same values, same order of layers. `root` must have passed check_scene.
std::string write_scene(const toml::table& root);

// The same, with an explanation of each key, and with all keys left at their defaults as comments to be
// uncommented. Follows the table of keys, except for the keys and tables named in `left_out`.
std::string write_documented_scene(const toml::table& root, std::span<const char* const> left_out);

// Each key, prefixed with the names of its tables and dots, and its value on one line.
std::vector<std::pair<std::string, std::string>> keys_and_values(const toml::table& root);

}  // namespace fascicle::scene
