// MurmurHash3, the 128-bit form for 64-bit machines, with seed 0: the digest that Alembic keeps before each
// sample. The algorithm is Austin Appleby's, in the public domain; this is our own writing of it.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace fascicle::formats {

// The two words in order; in the file each is little-endian.
std::array<std::uint64_t, 2> murmur3_x64_128(std::string_view bytes);

}  // namespace fascicle::formats
