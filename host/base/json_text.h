// Checks untrusted JSON before a library reads it.
#pragma once

#include <string_view>

namespace fascicle::base {

// Returns the text unchanged, or an empty text, which is not JSON, if values are nested deeper than 64
// levels. nlohmann copies ordered values by recursion, and a few hundred kilobytes of text can nest deeply
// enough to overflow a stack.
std::string_view shallow_json(std::string_view text);

}  // namespace fascicle::base
