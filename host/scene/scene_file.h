// Turns a scene file's text into a Scene.
#pragma once

#include <filesystem>
#include <string>

#include "host/scene/scene.h"

namespace fascicle::scene {

class LoadedFiles;

struct SceneText {
  std::string name;              // Scene::name
  std::string source;            // Scene::source; also the file name in messages
  std::string text;              // TOML
  std::filesystem::path folder;  // base folder of [mesh] file and [character] file
  LoadedFiles* files = nullptr;  // files read before; null: read every file
};

// Applies the overrides, checks everything, and loads the mesh or character. Throws SceneError.
Scene parse_scene(const SceneText& input, const SceneOverrides& overrides);

// The frames of a longer bake would fill any disk.
inline constexpr double most_frames = 1e7;

}  // namespace fascicle::scene
