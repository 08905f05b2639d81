// A scene from its text, and the error for an invalid text.
#pragma once

#include <filesystem>
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

}  // namespace fascicle::tests
