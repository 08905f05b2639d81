// Options of a bake, checked before anything is built or written.
#pragma once

#include <string>
#include <vector>

#include "host/bake/bake.h"

namespace fascicle::bake {

// Instead of formats: explicitly none.
inline constexpr const char* no_format = "none";

// Names accepted as formats: format_names() and no_format.
std::vector<std::string> accepted_formats();

// The formats to write, without no_format. Throws ContradictingOptions if no_format comes with others, or if
// neither frames nor a format would be left and no_format was not given.
std::vector<std::string> formats_to_write(const BakeOutput& output);

// The options with each format once, in the order of format_names(), including companion formats. Throws
// BakeError.
BakeOptions checked(BakeOptions options, const model::Model& model);

}  // namespace fascicle::bake
