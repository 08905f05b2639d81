#include "host/gltf/gltf_material.h"

#include <algorithm>
#include <cmath>

#include "host/base/trigonometry.h"

namespace fascicle::gltf {
namespace {

using nlohmann::json;

double number_or(const json& value, double otherwise) {
  if (!value.is_number()) return otherwise;
  const double number = value.get<double>();
  return std::isfinite(number) ? number : otherwise;
}

double share_or(const json& value, double otherwise) {
  return std::clamp(number_or(value, otherwise), 0.0, 1.0);
}

template <int Count>
Eigen::Matrix<double, Count, 1> numbers_or(const json& value, Eigen::Matrix<double, Count, 1> otherwise) {
  if (!value.is_array()) return otherwise;
  for (std::size_t k = 0; k < std::min<std::size_t>(Count, value.size()); ++k) {
    double& number = otherwise[static_cast<Eigen::Index>(k)];
    number = number_or(value[k], number);
  }
  return otherwise;
}

const json& extension(const json& value, const char* name) {
  return json_member(json_member(value, "extensions"), name);
}

// Offset * rotation * scale. A positive rotation turns coordinates counter-clockwise as seen with v up, so
// with v down the sines change sign; the extension's own example, the lower left quarter of an image, says
// so.
Eigen::Matrix<double, 2, 3> transform_of(const json& use) {
  constexpr double most = 1e6;  // keeps the coordinates finite
  const auto pair = [&](const char* name, const Eigen::Vector2d& otherwise) {
    return Eigen::Vector2d(numbers_or<2>(json_member(use, name), otherwise).cwiseMax(-most).cwiseMin(most));
  };
  const Eigen::Vector2d offset = pair("offset", Eigen::Vector2d::Zero());
  const Eigen::Vector2d scale = pair("scale", Eigen::Vector2d::Ones());
  const double angle = std::clamp(number_or(json_member(use, "rotation"), 0.0), -most, most);
  const double c = base::exact_cos(angle), s = base::exact_sin(angle);
  Eigen::Matrix<double, 2, 3> transform;
  transform << c * scale[0], s * scale[1], offset[0], -s * scale[0], c * scale[1], offset[1];
  return transform;
}

std::optional<TextureUse> read_use(const json& document, const json& use) {
  const std::optional<std::size_t> texture =
      json_index(json_member(use, "index"), json_member(document, "textures"));
  if (!texture) return std::nullopt;
  TextureUse result{.texture = *texture};
  const json& moved = extension(use, "KHR_texture_transform");
  if (moved.is_object()) result.transform = transform_of(moved);
  for (const json* value : {&json_member(use, "texCoord"), &json_member(moved, "texCoord")})
    if (value->is_number_unsigned()) result.uv_set = value->get<std::uint64_t>();
  return result;
}

TextureWrap wrap_of(const json& value) {
  if (value == 33071) return TextureWrap::clamp;
  if (value == 33648) return TextureWrap::mirror;
  return TextureWrap::repeat;
}

AlphaMode alpha_mode_of(const json& value) {
  if (value == "MASK") return AlphaMode::mask;
  if (value == "BLEND") return AlphaMode::blend;
  return AlphaMode::opaque;
}

}  // namespace

const json& json_member(const json& value, const char* name) {
  static const json nothing;
  if (!value.is_object()) return nothing;
  const auto found = value.find(name);
  return found == value.end() ? nothing : *found;
}

std::optional<std::size_t> json_index(const json& number, const json& list) {
  if (!number.is_number_unsigned() || !list.is_array()) return std::nullopt;
  const auto index = number.get<std::size_t>();
  return index < list.size() ? std::optional(index) : std::nullopt;
}

std::string json_text(const json& value, const std::string& otherwise) {
  return value.is_string() ? value.get<std::string>() : otherwise;
}

Material read_material(const json& document, const json& material) {
  Material result;
  result.name = json_text(json_member(material, "name"), "");
  const json& metallic = json_member(material, "pbrMetallicRoughness");
  const json& specular = extension(material, "KHR_materials_pbrSpecularGlossiness");
  const bool is_specular = specular.is_object();
  const json& colour =
      is_specular ? json_member(specular, "diffuseFactor") : json_member(metallic, "baseColorFactor");
  result.base_colour = numbers_or<4>(colour, result.base_colour).cwiseMax(0.0).cwiseMin(1.0);
  if (is_specular) {
    result.metallic = 0.0;
    result.roughness = 1.0 - share_or(json_member(specular, "glossinessFactor"), 1.0);
    result.specular = numbers_or<3>(json_member(specular, "specularFactor"), Eigen::Vector3d::Ones())
                          .cwiseMax(0.0)
                          .cwiseMin(1.0);
  } else {
    result.metallic = share_or(json_member(metallic, "metallicFactor"), 1.0);
    result.roughness = share_or(json_member(metallic, "roughnessFactor"), 1.0);
  }
  const json& strength =
      json_member(extension(material, "KHR_materials_emissive_strength"), "emissiveStrength");
  result.emission =
      numbers_or<3>(json_member(material, "emissiveFactor"), result.emission).cwiseMax(0.0).cwiseMin(1.0) *
      std::clamp(number_or(strength, 1.0), 0.0, 1e6);
  result.double_sided = json_member(material, "doubleSided") == true;
  result.alpha_mode = alpha_mode_of(json_member(material, "alphaMode"));
  result.alpha_cutoff = std::max(number_or(json_member(material, "alphaCutoff"), 0.5), 0.0);
  result.texture = read_use(document, is_specular ? json_member(specular, "diffuseTexture")
                                                  : json_member(metallic, "baseColorTexture"));
  return result;
}

TextureSource texture_source(const json& document, std::size_t texture) {
  const json& source = json_member(document, "textures")[texture];
  TextureSource result{.image = json_index(json_member(source, "source"), json_member(document, "images"))};
  const json& samplers = json_member(document, "samplers");
  if (const auto sampler = json_index(json_member(source, "sampler"), samplers)) {
    result.across = wrap_of(json_member(samplers[*sampler], "wrapS"));
    result.down = wrap_of(json_member(samplers[*sampler], "wrapT"));
  }
  return result;
}

}  // namespace fascicle::gltf
