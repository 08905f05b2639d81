// Paint files of a scene: applied to the characters, and their effect on layers.
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

// What a paint file paints on a character.
struct FilePaint {
  toml::source_region source;  // location of the key that names the file
  std::string key;             // "character.paint"
  std::set<std::string> names;
  std::set<int> layers;   // values of _LAYER other than 0
  float stiffest = 0.0f;  // largest _STIFFNESS
};

FilePaint file_paint(const rig::Paint& paint, const toml::source_region& source, const std::string& key);

// Reads the file, through `files` (may be null), and applies it to the character. Adds to scene.input_hashes.
// Throws InputFileError.
rig::Paint lay_paint_over(const std::filesystem::path& file, LoadedFiles* files, Scene& scene,
                          rig::Character& character);

// Applies default meanings of paint to layers that state none. If no `where` refers to _LAYER, 1 is the layer
// named bone, 2 muscle, 3 fat. If no layer names _STIFFNESS, it multiplies the stiffness of all layers that
// have no attribute for that; characters without it get 1. Throws SceneError if a painted layer is missing or
// a value is not allowed.
void let_paint_act(const std::vector<FilePaint>& paint, Scene& scene);

}  // namespace fascicle::scene
