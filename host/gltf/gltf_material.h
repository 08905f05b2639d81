// A glTF file's materials, and where their base colour textures lie. The file's JSON is read as it stands:
// looks are not checked, and anything faulty counts as absent.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

namespace fascicle::gltf {

enum class AlphaMode { opaque, mask, blend };
enum class TextureWrap { repeat, mirror, clamp };

// How a material uses a texture.
struct TextureUse {
  std::size_t texture = 0;   // index in the file
  std::uint64_t uv_set = 0;  // n of TEXCOORD_n
  // Texture coordinates are this times (u, v, 1), v down: KHR_texture_transform.
  Eigen::Matrix<double, 2, 3> transform = Eigen::Matrix<double, 2, 3>::Identity();
};

struct Material {
  std::string name;                                       // empty: none
  Eigen::Vector4d base_colour = Eigen::Vector4d::Ones();  // linear RGB, then alpha, all in [0, 1]
  double metallic = 1.0, roughness = 1.0;
  std::optional<Eigen::Vector3d> specular;  // colour at normal incidence, where the file gives it
  Eigen::Vector3d emission = Eigen::Vector3d::Zero();
  bool double_sided = false;
  AlphaMode alpha_mode = AlphaMode::opaque;
  double alpha_cutoff = 0.5;          // of AlphaMode::mask
  std::optional<TextureUse> texture;  // base colour
};

// KHR_materials_pbrSpecularGlossiness, if a material has it, decides over the metallic parameters.
Material read_material(const nlohmann::json& document, const nlohmann::json& material);

struct TextureSource {
  std::optional<std::size_t> image;  // index in the file; none: only an extension names one, or none is named
  TextureWrap across = TextureWrap::repeat, down = TextureWrap::repeat;
};

TextureSource texture_source(const nlohmann::json& document, std::size_t texture);

// The value's member; null if there is none.
const nlohmann::json& json_member(const nlohmann::json& value, const char* name);

// The index, if it is one of the list's.
std::optional<std::size_t> json_index(const nlohmann::json& number, const nlohmann::json& list);

std::string json_text(const nlohmann::json& value, const std::string& otherwise);

}  // namespace fascicle::gltf
