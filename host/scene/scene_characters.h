// The characters of a scene file: one, or several named ones that are joined.
#pragma once

#include <filesystem>
#include <vector>

#include "host/scene/input_files.h"
#include "host/scene/scene.h"
#include "host/scene/toml.h"

namespace fascicle::scene {

// Reads [character] or [character.NAME] into the scene's geometry, characters and input hashes. Throws
// SceneError. `files` may be null, here and below.
void read_character(const toml::table& root, const std::filesystem::path& folder, LoadedFiles* files,
                    Scene& scene);

// Smooths the clips that play (smooth_clip.h). The scene's times must have been read.
void smooth_clips(Scene& scene, bool repeats);

// The characters that a file will have after its overrides are applied, so far as they can be read. If the
// file has a character, returns at least one, possibly empty.
std::vector<rig::Character> characters_to_be(const toml::table& root, const std::filesystem::path& folder,
                                             LoadedFiles* files, const SceneOverrides& overrides);

}  // namespace fascicle::scene
