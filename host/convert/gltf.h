// Converts a character to glTF 2.0 in one file.
#pragma once

#include <filesystem>
#include <string>

#include "host/convert/character.h"

namespace fascicle::convert {

// The file's bytes. Images are looked for beside `source` and only referenced. Throws Failure if there are no
// triangles.
std::string glb_of(Character& character, const std::filesystem::path& source);

}  // namespace fascicle::convert
