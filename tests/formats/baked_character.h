// A glTF file's character as a bake keeps it in its folder.
#pragma once

#include <cstdint>
#include <filesystem>

#include "host/gltf/gltf_rig.h"
#include "host/model/model.h"
#include "host/scene/scene.h"
#include "tests/gltf/gltf_builder.h"

namespace fascicle::tests {

inline constexpr double baked_fps = 8.0;

// Frames 0 to 6 show the times 0.25 s to 1 s of the file's first clip.
struct Baked {
  TemporaryFolder folder;
  scene::Scene scene;
  model::Model model;
  std::filesystem::path character;  // character.glb

  Baked(const GltfBuilder& file, double scale);
  double time(std::uint64_t frame) const;
};

}  // namespace fascicle::tests
