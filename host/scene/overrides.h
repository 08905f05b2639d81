// Changes to a parsed scene file before it is checked.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "host/scene/scene.h"
#include "host/scene/toml.h"

namespace fascicle::scene {

// Applies --set in order, then the other options. Paths follow the table of keys. A user-chosen name
// (layers.NAME) must exist already, unless the value is the whole table. Setting one key of a choice removes
// the others. Throws SceneError that names the option.
void apply_overrides(toml::table& root, const SceneOverrides& overrides);

// Whether the scene has [character.NAME] rather than [character].
bool has_named_characters(const toml::table& root);

// The value that --set gives this path, without quotes; nullopt if none does. For values needed before the
// overrides can be applied.
std::optional<std::string> overridden(const SceneOverrides& overrides, std::string_view path);

}  // namespace fascicle::scene
