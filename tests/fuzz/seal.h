// Corrects the checksums of our own file formats after a fuzzer changed the bytes.
#pragma once

#include <string>
#include <string_view>

namespace fascicle::fuzz {

// Writes the XXH3-64 of [begin, end) into the 8 bytes after it. Does nothing if the bytes end before that.
void seal(std::string& bytes, std::size_t begin, std::size_t end);
// Corrects the last 8 bytes, the checksum of all bytes before them from `begin` on.
std::string sealed(std::string_view bytes, std::size_t begin = 0);

}  // namespace fascicle::fuzz
