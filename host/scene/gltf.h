// glTF 2.0 characters, .glb and .gltf.
#pragma once

#include <filesystem>

#include "host/scene/scene.h"

namespace fascicle::scene {

// Reads the skinned mesh, skeleton and clips of a glTF file; positions come out in metres in the bind pose. Throws
// SceneError with a JSON pointer to what is wrong. URIs outside the file's folder are refused.
Character read_gltf(const std::filesystem::path& path);

}  // namespace fascicle::scene
