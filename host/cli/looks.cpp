#include "host/cli/looks.h"

#include "host/scene/gltf_looks.h"
#include "host/scene/gltf_rig.h"

namespace fascicle::cli {

std::optional<render::Looks> looks_of(const std::filesystem::path& character, const model::Model& model,
                                      Log& log) {
  const scene::Rig rig = scene::read_rig(character);
  const scene::Looks read = scene::read_looks(character, rig);
  for (const std::string& note : read.notes) log.warning(character.string() + ": " + note);
  if (!read.has_colours) return std::nullopt;
  render::Looks looks;
  for (const scene::LookMaterial& material : read.materials)
    looks.paints.push_back({.colour = material.base_colour.head<3>().cast<float>(),
                            .alpha = static_cast<float>(material.base_colour[3]),
                            .cutoff = static_cast<float>(material.alpha_cutoff),
                            .texture = -1});
  bool has_uvs = false, has_vertex_colours = false;
  for (const scene::PartLooks& part : read.parts) {
    has_uvs = has_uvs || !part.uvs.empty();
    has_vertex_colours = has_vertex_colours || !part.colours.empty();
  }
  for (std::size_t p = 0; p < read.parts.size(); ++p) {
    const scene::PartLooks& part = read.parts[p];
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
                ": has not the vertices of the baked surface; it is drawn without its colours");
    return std::nullopt;
  }
  return looks;
}

}  // namespace fascicle::cli
