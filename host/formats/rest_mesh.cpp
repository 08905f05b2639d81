#include "host/formats/rest_mesh.h"

#include "host/base/part_file.h"
#include "host/base/text.h"
#include "host/formats/obj_text.h"
#include "host/formats/surface.h"

namespace fascicle::formats {

std::string rest_obj(const model::Model& model, const SurfaceObjects& surface) {
  const std::vector<float> world = world_positions(embed(model, model.rest), model.unit, model.rest_origin);
  std::string text = "# fascicle: the surface at rest, metres, Y up\n";
  if (!surface.materials.empty()) text += std::string("mtllib ") + rest_materials_name + '\n';
  for (std::size_t i = 0; i < world.size(); i += 3)
    text += "v " + base::number_text(world[i]) + ' ' + base::number_text(world[i + 1]) + ' ' +
            base::number_text(world[i + 2]) + '\n';
  std::uint64_t uvs = 0;
  for (const SurfaceObject& object : surface.objects) text += obj_uvs(object);
  for (const SurfaceObject& object : surface.objects) {
    if (surface.objects.size() > 1) text += "g " + obj_name(object.name) + '\n';
    text += obj_faces(surface, object, uvs, false);
    uvs += object.uvs.size() / 2;
  }
  return text;
}

void write_rest_mesh(const std::filesystem::path& folder, const model::Model& model,
                     const SurfaceObjects& surface) {
  base::write_whole(folder / rest_name, rest_obj(model, surface));
  if (surface.materials.empty()) return;
  base::write_whole(folder / rest_materials_name, mtl_text(surface, ""));
  write_textures(folder, surface);
}

}  // namespace fascicle::formats
