// Checks a parsed scene file against the table of keys, and locates nodes in the text.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/scene/scene_table.h"
#include "host/scene/toml.h"

namespace fascicle::scene {

// Overrides are parsed with the option's text as their file name ("--set a.b=1"), and have no line number.
bool is_override(const toml::source_region& source);

// "FILE:LINE", or the option that an override came from.
std::string location(const toml::source_region& source);

// The shortest text that parses to the same number.
std::string shortest(double value);

// Joins "layers" and "fat" to "layers.fat".
std::string join_path(std::string_view path, std::string_view name);

// Quoted keys and values can contain anything, but a message must be one line: base::shown_text.
std::string one_line(const std::string& text);

// Throws SceneError "FILE:LINE: PATH: MESSAGE".
[[noreturn]] void fail(const toml::source_region& source, std::string_view path, std::string_view message);
[[noreturn]] void fail_unknown(const toml::source_region& source, std::string_view path,
                               std::string_view name, const std::vector<std::string>& names);

// A table's entries in the order of the file (toml++'s map is alphabetical), then those added by overrides.
using Entry = std::pair<const toml::key*, const toml::node*>;
std::vector<Entry> in_order(const toml::table& table);

// Whether a table of this key contains tables whose names the user chose.
bool holds_named_tables(const Key& key, const toml::table& table);

// Throws SceneError at the first key that violates the table of keys. After it, every value has its type and
// range, required keys exist, and exactly one key of each choice is set.
void check_scene(const toml::table& root);

}  // namespace fascicle::scene
