// A scene from its text, its layers by name, and the errors for what cannot be loaded.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

#include "host/scene/scene_file.h"

namespace fascicle::tests {

inline scene::Scene parse(const std::string& text, const scene::SceneOverrides& overrides = {},
                          const std::filesystem::path& folder = {}) {
  return parse_scene({"sample", "sample.toml", text, folder}, overrides);
}

// The error message; "no error" if the text is accepted.
inline std::string refusal_of_text(const std::string& text, const scene::SceneOverrides& overrides = {}) {
  try {
    parse(text, overrides);
  } catch (const scene::SceneError& error) {
    return error.what();
  }
  return "no error";
}

// The error message when the scene or file of this name is loaded; "no error" if it is accepted.
inline std::string refusal(const std::string& name, const scene::SceneOverrides& overrides = {}) {
  try {
    scene::load_scene(name, overrides);
  } catch (const scene::SceneError& error) {
    return error.what();
  }
  return "no error";
}

inline const scene::Layer& layer(const scene::Scene& of, const std::string& name) {
  for (const scene::Layer& each : of.layers) {
    if (each.name == name) return each;
  }
  throw std::out_of_range(name);
}

}  // namespace fascicle::tests
