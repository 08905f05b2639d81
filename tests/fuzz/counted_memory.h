// How much memory this program holds, and at most held: what it asked `new` for. What libraries of C (libpng,
// libjpeg, zlib) ask malloc() for is not counted; the limits of `./do fuzz` are on all.
#pragma once

#include <cstddef>

namespace fascicle::fuzz {

std::size_t most_held_since_mark();
void mark_held();

}  // namespace fascicle::fuzz
