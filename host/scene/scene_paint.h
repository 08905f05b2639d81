// Paint files in a scene: laid over the characters, and what layers make of them.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "host/rig/paint.h"
#include "host/scene/input_files.h"
#include "host/scene/scene.h"
#include "host/scene/toml.h"

namespace fascicle::scene {

// What a paint file has on a character.
struct FilePaint {
  toml::source_region source;  // of the key that names the file
  std::string key;             // "character.paint"
  std::set<std::string> names;
  std::set<int> layers;   // values of _LAYER but 0
  float stiffest = 0.0f;  // largest _STIFFNESS
};

FilePaint file_paint(const rig::Paint& paint, const toml::source_region& source, const std::string& key);

// Reads the file, which `files` (may be null) keeps, and lays it over the character. Adds to
// scene.input_hashes. Throws InputFileError.
rig::Paint lay_paint_over(const std::filesystem::path& file, LoadedFiles* files, Scene& scene,
                          rig::Character& character);

// Layers that do not say what paint means for them do as those that a character gets without any. Where no
// `where` asks for _LAYER, 1 is the layer called bone, 2 muscle, 3 fat; a painted _STIFFNESS multiplies the
// stiffness of all layers without an attribute for that, where none of them names it; characters without it
// get 1. Throws SceneError where a layer for the paint is missing, or cannot have it.
void let_paint_act(const std::vector<FilePaint>& paint, Scene& scene);

}  // namespace fascicle::scene
