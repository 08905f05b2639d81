// From a scene file's text to a Scene.
#pragma once

#include <filesystem>
#include <string>

#include "host/scene/scene.h"

namespace fascicle::scene {

class LoadedFiles;

struct SceneText {
  std::string name;              // Scene::name
  std::string source;            // Scene::source; also stands for the file in messages
  std::string text;              // TOML
  std::filesystem::path folder;  // what [mesh] file and [character] file are relative to
  LoadedFiles* files = nullptr;  // what was read before; null: every file is read
};

// Applies the overrides, checks everything, loads the mesh or character. Throws SceneError.
Scene parse_scene(const SceneText& input, const SceneOverrides& overrides);

// Cutting frames finer than this would fill any disk.
inline constexpr double most_frames = 1e7;

}  // namespace fascicle::scene
