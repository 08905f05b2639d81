// The characters of a scene file: one, or several by name that are joined.
#pragma once

#include <filesystem>
#include <vector>

#include "host/scene/input_files.h"
#include "host/scene/scene.h"
#include "host/scene/toml.h"

namespace fascicle::scene {

// [character] or [character.NAME] into the scene's geometry, characters and input hashes. Throws SceneError.
// `files` may be null, here and below.
void read_character(const toml::table& root, const std::filesystem::path& folder, LoadedFiles* files,
                    Scene& scene);

// Makes the clips that play smooth (smooth_clip.h). The scene's times are read.
void smooth_clips(Scene& scene, bool repeats);

// The characters that a file will have once its overrides are applied, as far as they can be read; at least
// one, empty if need be, where the file has a character.
std::vector<rig::Character> characters_to_be(const toml::table& root, const std::filesystem::path& folder,
                                             LoadedFiles* files, const SceneOverrides& overrides);

}  // namespace fascicle::scene
