// Changes to a parsed scene file before it is checked.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "host/scene/scene.h"
#include "host/scene/toml.h"

namespace fascicle::scene {

// Applies --set in order, then the other options. A path leads through tables of the table of
// keys; a name that users choose (layers.NAME) must be there already, unless the value is the whole table.
// Setting one key of a choice drops the others. Throws SceneError that names the option.
void apply_overrides(toml::table& root, const SceneOverrides& overrides);

// Whether the scene has [character.NAME], not [character].
bool has_named_characters(const toml::table& root);

// What a --set puts there, without its quotes; nothing if none does. For what has to be known before the
// overrides can be applied.
std::optional<std::string> overridden(const SceneOverrides& overrides, std::string_view path);

}  // namespace fascicle::scene
