// Materials: base colour and its texture.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <assimp/scene.h>

#include "host/convert/document.h"

namespace fascicle::convert {

// Adds one glTF material for each of the scene's. Textures embedded in the file are copied; others are looked
// for in the folder of `source`, and referenced even if they are missing.
void add_materials(const aiScene& scene, const std::filesystem::path& source, Document& document,
                   std::vector<std::string>& notes);

}  // namespace fascicle::convert
