// Materials: base colour and the texture that has it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <assimp/scene.h>

#include "host/convert/document.h"

namespace fascicle::convert {

// Adds one glTF material for each of the scene's. Textures inside the file come along; others are looked for
// in the folder of `source`, and named even where they are not there.
void add_materials(const aiScene& scene, const std::filesystem::path& source, Document& document,
                   std::vector<std::string>& notes);

}  // namespace fascicle::convert
