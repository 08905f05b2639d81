#include "host/cli/looks.h"

#include <cstdint>
#include <string>
#include <vector>

#include "host/gltf/gltf_looks.h"
#include "host/gltf/gltf_rig.h"
#include "host/render/decode_image.h"

namespace fascicle::cli {
namespace {

constexpr std::size_t most_textures = 128;

// Maximum side of each of `count` textures: below 400 MiB in total, and far more detail than a picture of a
// body shows.
unsigned longest_side(std::size_t count) {
  return count <= 8 ? 2048 : count <= 32 ? 1024 : 512;
}

render::Wrap wrap_of(gltf::TextureWrap wrap) {
  return wrap == gltf::TextureWrap::clamp    ? render::Wrap::clamp
         : wrap == gltf::TextureWrap::mirror ? render::Wrap::mirror
                                             : render::Wrap::repeat;
}

// Adds the file's textures to looks.textures. Returns the index of each there, or -1 if it could not be read.
std::vector<std::int32_t> add_textures(const gltf::Looks& read, const std::string& file, render::Looks& looks,
                                       Log& log) {
  std::vector<std::int32_t> numbers;
  for (const gltf::LookTexture& texture : read.textures) {
    numbers.push_back(-1);
    if (numbers.size() > most_textures) continue;
    const render::DecodedImage image = render::decode_image(*texture.bytes);
    const bool is_read = !image.texels.values.empty();
    if (!image.flaw.empty())
      log.warning(file + ": " + texture.name + " " + image.flaw +
                  (is_read ? "" : "; its surface gets its plain colour"));
    if (!is_read) continue;
    numbers.back() = static_cast<std::int32_t>(looks.textures.size());
    looks.textures.emplace_back(image.texels, wrap_of(texture.across), wrap_of(texture.down),
                                longest_side(read.textures.size()));
  }
  if (read.textures.size() > most_textures)
    log.warning(file + ": has " + std::to_string(read.textures.size()) + " textures; only the first " +
                std::to_string(most_textures) + " are drawn");
  return numbers;
}

}  // namespace

std::optional<render::Looks> looks_of(const std::filesystem::path& character, const model::Model& model,
                                      Log& log) {
  const gltf::Rig rig = gltf::read_rig(character);
  const gltf::Looks read = gltf::read_looks(character, rig);
  for (const std::string& note : read.notes) log.warning(character.string() + ": " + note);
  if (!read.has_colours) return std::nullopt;
  render::Looks looks;
  const std::vector<std::int32_t> textures = add_textures(read, character.string(), looks, log);
  for (const gltf::LookMaterial& material : read.materials)
    looks.paints.push_back(
        {.colour = material.base_colour.head<3>().cast<float>(),
         .alpha = static_cast<float>(material.base_colour[3]),
         .cutoff = static_cast<float>(material.alpha_cutoff),
         .texture = material.texture < 0 ? -1 : textures[static_cast<std::size_t>(material.texture)]});
  bool has_uvs = false, has_vertex_colours = false;
  for (const gltf::PartLooks& part : read.parts) {
    has_uvs = has_uvs || !part.uvs.empty();
    has_vertex_colours = has_vertex_colours || !part.colours.empty();
  }
  for (std::size_t p = 0; p < read.parts.size(); ++p) {
    const gltf::PartLooks& part = read.parts[p];
    for (std::size_t i = 0; i < rig.parts[p].positions.size(); ++i) {
      looks.paint_of_vertex.push_back(part.material);
      if (has_uvs)
        looks.uvs.push_back(part.uvs.empty() ? render::Vector2f(0.0f, 0.0f) : part.uvs[i].cast<float>());
      if (has_vertex_colours)
        looks.colours.push_back(part.colours.empty() ? render::Vector3f(1.0f, 1.0f, 1.0f)
                                                     : part.colours[i].cast<float>());
    }
  }
  if (looks.paint_of_vertex.size() != model.surface_count()) {
    log.warning(character.string() +
                ": its vertices do not match the baked surface; it is drawn without its colours");
    return std::nullopt;
  }
  return looks;
}

}  // namespace fascicle::cli
