// Scene files for a mesh or a character given without one.
#pragma once

#include <filesystem>
#include <string>

#include "host/scene/scene.h"

namespace fascicle::scene {

// One soft layer under gravity, its lowest 5 % held.
// The substeps are chosen from the mesh's size and mean edge, so that it stands under its own weight.
std::string scene_for_mesh(const std::filesystem::path& path, const Geometry& mesh);

// Bone, muscle and fat as in figure 9, by distance from the bones, in proportion to the character's size.
std::string scene_for_character(const std::filesystem::path& path, const Character& character);

}  // namespace fascicle::scene
