#include "host/page/page_looks.h"

#include <algorithm>
#include <cmath>

#include "host/gltf/gltf_looks.h"
#include "host/gltf/gltf_rig.h"
#include "host/render/colour.h"
#include "host/render/decode_image.h"
#include "host/render/jpeg.h"
#include "host/render/looks.h"
#include "host/render/png.h"

namespace fascicle::page {

namespace {

constexpr std::size_t most_textures = 64;
// Textures within the size limits and with fewer bytes than this are embedded unchanged.
constexpr std::size_t most_bytes = std::size_t{512} << 10;
constexpr int jpeg_quality = 88;

// The largest side for each of `count` textures.
unsigned longest_side(std::size_t count) {
  return count <= 4 ? 1024 : count <= 16 ? 512 : 256;
}

std::string wrap_name(gltf::TextureWrap wrap) {
  return wrap == gltf::TextureWrap::clamp ? "clamp" : wrap == gltf::TextureWrap::mirror ? "mirror" : "repeat";
}

bool has_holes(const render::Texels& texels) {
  for (std::size_t k = 3; k < texels.values.size(); k += 4)
    if (texels.values[k] != 255) return true;
  return false;
}

// Empty for a texture that cannot be read; faults are added to `warnings`.
PageTexture page_texture(const gltf::LookTexture& texture, unsigned most,
                         std::vector<std::string>& warnings) {
  const render::DecodedImage image = render::decode_image(*texture.bytes);
  if (!image.flaw.empty())
    warnings.push_back(texture.name + " " + image.flaw +
                       (image.texels.values.empty() ? "; its surface gets its plain colour" : ""));
  if (image.texels.values.empty()) return {};
  PageTexture kept;
  kept.across = wrap_name(texture.across);
  kept.down = wrap_name(texture.down);
  const bool is_png = texture.bytes->front() == 0x89;
  if (image.flaw.empty() && std::max(image.texels.width, image.texels.height) <= most &&
      texture.bytes->size() <= most_bytes) {
    kept.type = is_png ? "image/png" : "image/jpeg";
    kept.bytes.assign(texture.bytes->begin(), texture.bytes->end());
    return kept;
  }
  const render::Texels smaller =
      render::Texture(image.texels, render::Wrap::repeat, render::Wrap::repeat, most).texels();
  kept.type = has_holes(smaller) ? "image/png" : "image/jpeg";
  kept.bytes = has_holes(smaller) ? render::encode_png(smaller) : render::encode_jpeg(smaller, jpeg_quality);
  return kept;
}

PageLooks plain_looks(const model::Model& model) {
  PageLooks looks;
  const render::Vector3f skin = render::skin_tone();
  looks.materials.push_back({.name = "skin", .colour = {skin[0], skin[1], skin[2]}});
  looks.material.assign(model.surface_count(), 0);
  return looks;
}

// A page's textures are not multiplied by the base colour's alpha, so the cutoff is divided by it.
double texture_cutoff(const gltf::LookMaterial& material) {
  constexpr double all = 2.0;  // more than any alpha
  if (material.alpha_cutoff <= 0.0) return 0.0;
  return material.base_colour[3] > 0.0 ? std::min(material.alpha_cutoff / material.base_colour[3], all) : all;
}

std::uint8_t colour_byte(double linear) {
  return render::byte_of_linear(static_cast<float>(linear));
}

}  // namespace

PageLooks page_looks(const std::filesystem::path& character, const model::Model& model) {
  if (character.empty()) return plain_looks(model);
  const gltf::Rig rig = gltf::read_rig(character);
  const gltf::Looks read = gltf::read_looks(character, rig);
  PageLooks looks;
  looks.warnings = read.notes;
  if (!read.has_colours) return plain_looks(model);
  looks.is_painted = true;
  std::vector<std::int32_t> numbers;  // per texture of the file
  for (const gltf::LookTexture& texture : read.textures) {
    numbers.push_back(-1);
    if (numbers.size() > most_textures) continue;
    PageTexture kept = page_texture(texture, longest_side(read.textures.size()), looks.warnings);
    if (kept.bytes.empty()) continue;
    numbers.back() = static_cast<std::int32_t>(looks.textures.size());
    looks.textures.push_back(std::move(kept));
  }
  if (read.textures.size() > most_textures)
    looks.warnings.push_back("only the first " + std::to_string(most_textures) + " of " +
                             std::to_string(read.textures.size()) + " textures are shown");
  for (const gltf::LookMaterial& material : read.materials)
    looks.materials.push_back(
        {.name = material.name,
         .colour = {material.base_colour[0], material.base_colour[1], material.base_colour[2]},
         .cutoff = texture_cutoff(material),
         .texture = material.texture < 0 ? -1 : numbers[static_cast<std::size_t>(material.texture)]});
  bool has_uvs = false, has_colours = false;
  for (const gltf::PartLooks& part : read.parts) {
    has_uvs = has_uvs || !part.uvs.empty();
    has_colours = has_colours || !part.colours.empty();
  }
  for (std::size_t p = 0; p < read.parts.size(); ++p) {
    const gltf::PartLooks& part = read.parts[p];
    for (std::size_t i = 0; i < rig.parts[p].positions.size(); ++i) {
      looks.material.push_back(part.material);
      if (has_uvs)
        looks.uvs.push_back(part.uvs.empty() ? std::array<float, 2>{}
                                             : std::array<float, 2>{static_cast<float>(part.uvs[i][0]),
                                                                    static_cast<float>(part.uvs[i][1])});
      if (!has_colours) continue;
      std::array<std::uint8_t, 3> colour{255, 255, 255};
      for (int c = 0; c < 3 && !part.colours.empty(); ++c)
        colour[static_cast<std::size_t>(c)] = colour_byte(part.colours[i][c]);
      looks.colours.push_back(colour);
    }
  }
  if (looks.material.size() == model.surface_count()) return looks;
  PageLooks plain = plain_looks(model);
  plain.warnings.push_back("its vertices do not match the baked surface; it is shown without its colours");
  return plain;
}

}  // namespace fascicle::page
