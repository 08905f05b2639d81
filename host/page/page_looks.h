// A character's materials and textures in the form that a page embeds.
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
  std::string bytes;         // a complete file of that type
  std::string across, down;  // "repeat", "mirror" or "clamp"
};

struct PageMaterial {
  std::string name;
  std::array<double, 3> colour{1.0, 1.0, 1.0};  // linear; multiplies the texture
  double cutoff = 0.0;                          // cut out where the texture's alpha is lower; 0: off
  std::int32_t texture = -1;                    // index; -1: none
};

struct PageLooks {
  bool is_painted = false;  // whether the file defines any colour; else there is one material, skin
  std::vector<PageTexture> textures;
  std::vector<PageMaterial> materials;
  std::vector<std::uint32_t> material;               // per render vertex; a triangle uses its first corner's
  std::vector<std::array<float, 2>> uvs;             // per render vertex, v down; or empty
  std::vector<std::array<std::uint8_t, 3>> colours;  // per render vertex, sRGB; or empty
  std::vector<std::string> warnings;
};

// `character`: the bake's character.glb; empty: a body without one. Throws SceneError if it cannot be read.
PageLooks page_looks(const std::filesystem::path& character, const model::Model& model);

}  // namespace fascicle::page
