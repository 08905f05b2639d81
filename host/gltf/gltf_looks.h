// The colours of a glTF character, for pictures: materials, textures as they lie in the file, and what each
// vertex has of them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/gltf/gltf_rig.h"

namespace fascicle::gltf {

enum class TextureWrap { repeat, mirror, clamp };

struct LookTexture {
  std::string name;                  // for messages
  std::vector<unsigned char> bytes;  // PNG, JPEG or something else, not decoded
  TextureWrap across = TextureWrap::repeat, down = TextureWrap::repeat;
};

struct LookMaterial {
  std::string name;
  Eigen::Vector4d base_colour = Eigen::Vector4d::Ones();  // linear light, alpha last
  double alpha_cutoff = 0.0;                              // holes where alpha is below it; 0: none
  std::int32_t texture = -1;                              // index; -1: none
};

// Of one part of a rig.
struct PartLooks {
  std::uint32_t material = 0;
  std::vector<Eigen::Vector2d> uvs;      // of the material's texture, v down: one a position, or none
  std::vector<Eigen::Vector3d> colours;  // COLOR_0, linear light: one a position, or none
};

struct Looks {
  std::vector<LookTexture> textures;
  std::vector<LookMaterial> materials;  // the file's, then white for parts without one
  std::vector<PartLooks> parts;         // in the rig's order
  std::vector<std::string> notes;       // textures that were left out, and why
  // Whether the file says anything of colour.
  bool has_colours = false;
};

// `rig` must be read_rig(path). What is not as it should be becomes a note and plain colour; throws
// SceneError only where read_rig does.
Looks read_looks(const std::filesystem::path& path, const Rig& rig);

}  // namespace fascicle::gltf
