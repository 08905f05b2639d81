// Writes paint into a character's file as vertex attributes, in the form that read_gltf reads.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/rig/paint.h"

namespace fascicle::formats {

// Returns a .glb: the file as packed by gltf::pack_gltf, with an attribute for each painted one. `character`
// must be read_gltf of the file, with the paint added. A mesh shared by several nodes is duplicated. The
// names of missing images go into `missing`.
std::string painted_glb(const std::filesystem::path& file, const rig::Character& character,
                        const rig::Paint& paint, std::vector<std::string>& missing);

}  // namespace fascicle::formats
