// Our own files that end with the XXH3-64 of everything before.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "host/base/file.h"

namespace fascicle::bake {

// Longer files are taken for damaged. A model of 80 million vertices is as long, at about 840 bytes a vertex.
inline constexpr std::uint64_t most_sealed_bytes = std::uint64_t{64} << 30;

// The whole file. If it does not begin with `magic`, is too long or has another checksum: at most its
// beginning, as long as `magic`, which no parser accepts. A damaged file takes no memory, whatever its
// length: the checksum is checked in pieces first, because a sparse file of any length takes no space.
std::string read_sealed(const base::File& file, std::string_view magic);

// Whether these bytes of the file end with the XXH3-64 of those before. Takes no memory, whatever their
// number.
bool is_sealed_part(const base::File& file, std::uint64_t begin, std::uint64_t bytes);

}  // namespace fascicle::bake
