// The colours of a glTF character, for rendering: materials, undecoded textures, UVs and vertex colours.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/gltf/gltf_images.h"
#include "host/gltf/gltf_material.h"
#include "host/gltf/gltf_rig.h"

namespace fascicle::gltf {

struct LookTexture {
  std::string name;  // for messages
  ImageBytes bytes;  // PNG, JPEG or other, not decoded; never empty
  TextureWrap across = TextureWrap::repeat, down = TextureWrap::repeat;
};

struct LookMaterial {
  std::string name;
  Eigen::Vector4d base_colour = Eigen::Vector4d::Ones();  // linear RGB, then alpha
  double alpha_cutoff = 0.0;                              // cut out where alpha is lower; 0: off
  std::int32_t texture = -1;                              // index; -1: none
};

// The looks of one part of a rig.
struct PartLooks {
  std::uint32_t material = 0;
  std::vector<Eigen::Vector2d> uvs;      // for the material's texture, v down: one per position, or empty
  std::vector<Eigen::Vector3d> colours;  // COLOR_0, linear light: one per position, or empty
};

struct Looks {
  std::vector<LookTexture> textures;
  std::vector<LookMaterial> materials;  // the file's, then a white one for parts without a material
  std::vector<PartLooks> parts;         // in the order of the rig's parts
  std::vector<std::string> notes;       // textures that were left out, and why
  // Whether the file defines any colour.
  bool has_colours = false;
};

// `rig` must be read_rig(path). Faulty looks become a note and a plain colour; throws SceneError only if
// read_rig does.
Looks read_looks(const std::filesystem::path& path, const Rig& rig);

}  // namespace fascicle::gltf
