// Work that falls into independent pieces, on several threads.
#pragma once

#include <cstddef>
#include <functional>

namespace fascicle::render {

// Calls job(k) once for every k < count, on up to `threads` threads (0: one for each core). Which thread
// takes which k is left to chance: a job writes only what is its own. The first exception of a job is thrown
// on.
void for_each_index(std::size_t count, unsigned threads, const std::function<void(std::size_t)>& job);

}  // namespace fascicle::render
