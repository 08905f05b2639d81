// The only entry point for external TOML: scene files, lists of jobs, values of --set.
#pragma once

#include <string>
#include <string_view>

#include "host/scene/toml.h"

namespace fascicle::scene {

// Maximum size of a TOML file.
inline constexpr std::uint64_t most_toml_bytes = std::uint64_t{16} << 20;

// `source` names the text in messages. Throws SceneError with line and column if the text is not valid TOML.
// Texts that would crash toml++ are rejected before it sees them: it frees trees recursively, however deep
// the text makes them, and damaged UTF-8 takes it into states that it assumes impossible.
toml::table parse_toml(std::string_view text, std::string_view source);

// A text as a TOML string, with quotes.
std::string toml_string(const std::string& text);

}  // namespace fascicle::scene
