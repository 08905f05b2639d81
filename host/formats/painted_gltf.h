// A character's file with what is painted on it as attributes of its vertices, which the program reads as it
// reads the paint itself.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/rig/paint.h"

namespace fascicle::formats {

// Bytes of a .glb: the file as it is but for its form (gltf::pack_gltf), with an attribute of each of the
// paint's. `character` is what read_gltf gave of the file, with the paint laid over. A mesh that several
// nodes show becomes one of each. `missing` gets the names of images that are not there.
std::string painted_glb(const std::filesystem::path& file, const rig::Character& character,
                        const rig::Paint& paint, std::vector<std::string>& missing);

}  // namespace fascicle::formats
