#include "host/formats/obj_text.h"

#include <algorithm>
#include <vector>

#include "host/base/text.h"

namespace fascicle::formats {

namespace {

std::string triple(const std::array<double, 3>& v) {
  return base::number_text(v[0]) + ' ' + base::number_text(v[1]) + ' ' + base::number_text(v[2]);
}

}  // namespace

std::string obj_name(const std::string& name) {
  std::string word = name;
  std::replace(word.begin(), word.end(), ' ', '_');
  return word;
}

std::string mtl_text(const SurfaceObjects& surface, const std::string& to_folder) {
  std::string text = "# fascicle: colours are linear\n";
  for (const SurfaceMaterial& material : surface.materials) {
    text += "\nnewmtl " + obj_name(material.name) + "\nKd " + triple(material.color) + "\nKe " +
            triple(material.emission) + "\nd " + base::number_text(opacity_of(material)) + "\nPr " +
            base::number_text(material.roughness) + "\nPm " + base::number_text(material.metallic) +
            "\nillum 2\n";
    if (material.specular) text += "Ks " + triple(*material.specular) + '\n';
    if (material.texture.empty()) continue;
    text += "map_Kd " + to_folder + material.texture + '\n';
    if (!is_opaque(material) && material.texture.ends_with(".png"))
      text += "map_d " + to_folder + material.texture + '\n';
  }
  return text;
}

std::string obj_uvs(const SurfaceObject& object) {
  std::string text;
  for (std::size_t i = 0; i < object.uvs.size(); i += 2)
    text += "vt " + base::number_text(object.uvs[i]) + ' ' + base::number_text(object.uvs[i + 1]) + '\n';
  return text;
}

std::string obj_faces(const SurfaceObjects& surface, const SurfaceObject& object, std::uint64_t uvs_before,
                      bool with_normals) {
  std::string text;
  const auto add = [&](std::uint32_t t) {
    text += 'f';
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t vertex = object.triangle[std::size_t{3} * t + k];
      const std::string corner = base::number_text(vertex + object.first_vertex + 1);
      text += ' ' + corner;
      if (!object.uvs.empty())
        text += '/' + base::number_text(vertex + uvs_before + 1);
      else if (with_normals)
        text += '/';
      if (with_normals) text += '/' + corner;
    }
    text += '\n';
  };
  std::vector<bool> written(object.triangle.size() / 3, false);
  for (const FaceSet& set : object.face_sets)
    for (const std::uint32_t t : set.triangles) written[t] = true;
  // Triangles without a material come first, because OBJ cannot end a usemtl.
  for (std::uint32_t t = 0; t < written.size(); ++t)
    if (!written[t]) add(t);
  for (const FaceSet& set : object.face_sets) {
    text += "usemtl " + obj_name(surface.materials[set.material].name) + '\n';
    for (const std::uint32_t t : set.triangles) add(t);
  }
  return text;
}

}  // namespace fascicle::formats
