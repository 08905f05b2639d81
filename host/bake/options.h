// What may be asked of a bake, before anything is built or written.
#pragma once

#include <string>
#include <vector>

#include "host/bake/bake.h"

namespace fascicle::bake {

// In place of formats: none, said on purpose.
inline constexpr const char* no_format = "none";

// Names accepted where formats are: format_names() and no_format.
std::vector<std::string> accepted_formats();

// The formats to write, without no_format. Throws ContradictingOptions where no_format has others beside it,
// or where neither frames nor a format would be left and nobody said that this is meant.
std::vector<std::string> formats_to_write(const BakeOutput& output);

// The options with each format once, in the order of format_names(), and what these need beside them. Throws
// BakeError.
BakeOptions checked(BakeOptions options, const model::Model& model);

}  // namespace fascicle::bake
