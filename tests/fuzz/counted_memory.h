// Current and peak memory that this program allocated with `new`. malloc() in C libraries (libpng, libjpeg,
// zlib) is not counted; the limits of `./do fuzz` include it.
#pragma once

#include <cstddef>

namespace fascicle::fuzz {

std::size_t most_held_since_mark();
void mark_held();

}  // namespace fascicle::fuzz
