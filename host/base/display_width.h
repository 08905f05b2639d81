// How wide text is on a terminal.
#pragma once

#include <cstddef>
#include <string_view>

namespace fascicle::base {

// Columns that the text takes: combining marks take none, wide letters such as Chinese ones two.
std::size_t display_width(std::string_view text);

}  // namespace fascicle::base
