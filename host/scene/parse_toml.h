// The one door for TOML that comes from outside: scene files, lists of jobs, values of --set.
#pragma once

#include <string>
#include <string_view>

#include "host/scene/toml.h"

namespace fascicle::scene {

// Of a file of TOML.
inline constexpr std::uint64_t most_toml_bytes = std::uint64_t{16} << 20;

// `source` is what messages call the text. Throws SceneError with line and column where it is no TOML, and
// before toml++ sees it where that would be its end: nodes of a tree as deep as a text can make it are freed
// by recursion, and damaged UTF-8 reaches states it takes for impossible.
toml::table parse_toml(std::string_view text, std::string_view source);

// A text as it stands in TOML, with its quotes.
std::string toml_string(const std::string& text);

}  // namespace fascicle::scene
