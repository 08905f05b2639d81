// Checks untrusted JSON before a library reads it.
#pragma once

#include <string_view>

namespace fascicle::base {

// Returns the text unchanged, or an empty text, which is not JSON, if values are nested deeper than `deepest`
// levels, or an object has more than `most_keys` keys. nlohmann copies ordered values by recursion, and a few
// hundred kilobytes of text can nest deeply enough to overflow a stack. It finds a key by comparing with all
// before it: a megabyte of keys would take a minute.
inline constexpr unsigned deepest_nesting = 64;
std::string_view shallow_json(std::string_view text, unsigned most_keys = 10'000,
                              unsigned deepest = deepest_nesting);

}  // namespace fascicle::base
