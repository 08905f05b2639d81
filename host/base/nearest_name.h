// Hints for mistyped names.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace fascicle::base {

// The name nearest to `given` by Damerau-Levenshtein distance; the first in a tie. Empty if none is near: a
// name that differs in more than a third of its letters is a guess, not a hint. A name that ends in "/"
// followed by `given` takes precedence.
std::string nearest_name(std::string_view given, const std::vector<std::string>& names);

// "; did you mean NAME?", or empty if none is near.
std::string nearest_name_hint(std::string_view given, const std::vector<std::string>& names);

}  // namespace fascicle::base
