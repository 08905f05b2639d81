// How much memory this program holds, and at most held: what it asked `new` for.
#pragma once

#include <cstddef>

namespace fascicle::fuzz {

std::size_t most_held_since_mark();
void mark_held();

}  // namespace fascicle::fuzz
