// MurmurHash3, x64 128-bit variant, seed 0: the digest that Alembic stores before each sample. The algorithm
// is Austin Appleby's, in the public domain; this is an independent implementation.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace fascicle::formats {

// The two words, in order; Alembic stores each in little-endian.
std::array<std::uint64_t, 2> murmur3_x64_128(std::string_view bytes);

}  // namespace fascicle::formats
