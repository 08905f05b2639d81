// A parsed scene file against the table of keys, and where in the text things stand.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/scene/scene_table.h"
#include "host/scene/toml.h"

namespace fascicle::scene {

// Overrides are parsed under the option's text as their file name ("--set a.b=1"), which has no lines.
bool is_override(const toml::source_region& source);

// "FILE:LINE", or the option an override came from.
std::string location(const toml::source_region& source);

// The shortest text that reads back to the same number.
std::string shortest(double value);

// "layers" and "fat" to "layers.fat".
std::string join_path(std::string_view path, std::string_view name);

// Quoted keys and values may hold anything; a message is one line: base::shown_text.
std::string one_line(const std::string& text);

// Throws SceneError "FILE:LINE: PATH: MESSAGE".
[[noreturn]] void fail(const toml::source_region& source, std::string_view path, std::string_view message);
[[noreturn]] void fail_unknown(const toml::source_region& source, std::string_view path,
                               std::string_view name, const std::vector<std::string>& names);

// A table's entries as they stand in the file (the map itself is alphabetical), then those that overrides
// added.
using Entry = std::pair<const toml::key*, const toml::node*>;
std::vector<Entry> in_order(const toml::table& table);

// Whether a table of this key is a table of tables whose names the user chose.
bool holds_named_tables(const Key& key, const toml::table& table);

// Throws SceneError at the first key that the table of keys does not allow. After it every value has its type
// and range, required keys are there, and of each choice exactly one.
void check_scene(const toml::table& root);

}  // namespace fascicle::scene
