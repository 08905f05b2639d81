// The materials and textures of a character, as a page carries them.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/model/model.h"

namespace fascicle::page {

struct PageTexture {
  std::string type;          // "image/png" or "image/jpeg"
  std::string bytes;         // a whole file of that type
  std::string across, down;  // "repeat", "mirror" or "clamp"
};

struct PageMaterial {
  std::string name;
  std::array<double, 3> colour{1.0, 1.0, 1.0};  // linear light; multiplies the texture
  double cutoff = 0.0;                          // holes where alpha is below it; 0: none
  std::int32_t texture = -1;                    // index; -1: none
};

struct PageLooks {
  bool is_painted = false;  // whether the file says anything of colour; else one material, skin
  std::vector<PageTexture> textures;
  std::vector<PageMaterial> materials;
  std::vector<std::uint32_t> material;               // of a render vertex; a triangle has its first corner's
  std::vector<std::array<float, 2>> uvs;             // of a render vertex, v down; or none
  std::vector<std::array<std::uint8_t, 3>> colours;  // likewise, sRGB
  std::vector<std::string> warnings;
};

// `character`: character.glb of the bake; empty: a body without one. Throws SceneError where it cannot be
// read.
PageLooks page_looks(const std::filesystem::path& character, const model::Model& model);

}  // namespace fascicle::page
