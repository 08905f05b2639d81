// A character as glTF 2.0 in one file.
#pragma once

#include <filesystem>
#include <string>

#include "host/convert/character.h"

namespace fascicle::convert {

// Its bytes. Images are looked for beside `source`, and only named. Throws Failure where there are no
// triangles.
std::string glb_of(Character& character, const std::filesystem::path& source);

}  // namespace fascicle::convert
