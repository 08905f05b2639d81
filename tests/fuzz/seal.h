// The checksums of our own files, for bytes that a fuzzer has changed.
#pragma once

#include <string>
#include <string_view>

namespace fascicle::fuzz {

// With the XXH3-64 of [begin, end) in the 8 bytes that follow; as they are where they end before.
void seal(std::string& bytes, std::size_t begin, std::size_t end);
// The last 8 bytes of all, over those from `begin` on.
std::string sealed(std::string_view bytes, std::size_t begin = 0);

}  // namespace fascicle::fuzz
