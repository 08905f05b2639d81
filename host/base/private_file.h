// Files that only their owner may read.
#pragma once

#include <filesystem>
#include <string_view>

namespace fascicle::base {

// Writes a new file in place of any that is there, also of a link. Throws std::system_error.
void write_private(const std::filesystem::path& path, std::string_view text);

}  // namespace fascicle::base
