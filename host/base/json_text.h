// JSON of strangers, before a library reads it.
#pragma once

#include <string_view>

namespace fascicle::base {

// The text as it is; where its values are nested deeper than 64 levels, an empty one, which is no JSON.
// nlohmann's ordered values are copied by recursion, and a text of a few hundred kilobytes is as deep as a
// stack.
std::string_view shallow_json(std::string_view text);

}  // namespace fascicle::base
