#include "host/formats/surface_objects.h"

#include <algorithm>
#include <map>
#include <span>
#include <string>
#include <tuple>

#include <Eigen/Core>
#include <Eigen/LU>

#include "host/base/errors.h"
#include "host/base/part_file.h"
#include "host/base/text.h"
#include "host/formats/unique_names.h"
#include "host/gltf/gltf.h"
#include "host/gltf/gltf_file.h"
#include "host/gltf/gltf_images.h"
#include "host/gltf/gltf_material.h"
#include "host/gltf/gltf_rig.h"

namespace fascicle::formats {

namespace {

namespace fs = std::filesystem;
using Eigen::Matrix4d;
using Eigen::Vector3d;
using nlohmann::json;

constexpr const char* texture_prefix = "image_";

// A name that every format can store on one line and in a path.
std::string one_line(const std::string& name) {
  std::string result = name;
  for (char& c : result)
    if (c == '/' || static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = '_';
  return result;
}

// An entry of one of the document's lists; null if there is none.
const json* entry(const json& document, const char* list, const json& number) {
  const auto entries = document.find(list);
  if (entries == document.end() || !entries->is_array() || !number.is_number_unsigned()) return nullptr;
  const auto k = number.get<std::size_t>();
  return k < entries->size() && (*entries)[k].is_object() ? &(*entries)[k] : nullptr;
}

// One file's looks; reads each material and image once, on first use.
class Looks {
 public:
  Looks(const gltf::GltfFile& file, SurfaceObjects& to) : file_(file), to_(to) {}

  // Its index in SurfaceObjects::materials.
  std::uint32_t material(std::size_t in_file) {
    const auto known = std::find(materials_.begin(), materials_.end(), in_file);
    if (known != materials_.end()) return static_cast<std::uint32_t>(known - materials_.begin());
    materials_.push_back(in_file);
    const gltf::Material read =
        gltf::read_material(file_.document, *entry(file_.document, "materials", in_file));
    SurfaceMaterial material;
    std::string wanted = one_line(read.name);
    if (wanted.empty()) wanted = "material " + base::number_text(std::uint64_t{in_file});
    material.name = names_.take(wanted);
    material.identifier = identifiers_.take(identifier_of(wanted));
    const auto triple = [](const Vector3d& c) { return std::array<double, 3>{c[0], c[1], c[2]}; };
    material.color = triple(read.base_colour.head<3>());
    material.alpha = read.base_colour[3];
    material.alpha_mode = read.alpha_mode;
    material.alpha_cutoff = read.alpha_cutoff;
    material.metallic = read.metallic;
    material.roughness = read.roughness;
    if (read.specular) material.specular = triple(*read.specular);
    material.emission = triple(read.emission);
    material.double_sided = read.double_sided;
    if (read.texture) {
      const gltf::TextureSource source = gltf::texture_source(file_.document, read.texture->texture);
      if (source.image) material.texture = texture(*source.image);
      material.wrap_across = source.across;
      material.wrap_up = source.down;
    }
    to_.materials.push_back(std::move(material));
    return static_cast<std::uint32_t>(to_.materials.size() - 1);
  }

 private:
  // The file of an image; empty if the image is neither PNG nor JPEG, or not in a buffer view.
  std::string texture(std::size_t number) {
    const json& image = file_.document["images"][number];
    const json* view = entry(file_.document, "bufferViews", gltf::json_member(image, "bufferView"));
    if (view == nullptr) return {};
    const auto number_of = [&](const char* name) {
      const json& value = gltf::json_member(*view, name);
      return value.is_number_unsigned() ? value.get<std::uint64_t>() : 0;
    };
    const std::uint64_t offset = number_of("byteOffset"), bytes = number_of("byteLength");
    if (offset > file_.binary.size() || bytes > file_.binary.size() - offset) return {};
    const auto* begin = file_.binary.data() + offset;
    std::string media_type = gltf::media_type_of({begin, begin + std::min<std::uint64_t>(bytes, 16)});
    if (media_type.empty()) media_type = gltf::json_text(gltf::json_member(image, "mimeType"), "");
    if (media_type == "image/webp" || media_type == "image/ktx2") return {};
    const std::string type = media_type == "image/png" ? ".png" : ".jpg";
    std::string& path = path_of_[{offset, bytes, type}];
    if (!path.empty()) return path;
    // Views that overlap would make a small file's textures huge.
    if (bytes > bytes_left_) return {};
    bytes_left_ -= bytes;
    std::string digits = base::number_text(std::uint64_t{number});
    if (digits.size() < 3) digits.insert(0, 3 - digits.size(), '0');
    path = std::string(textures_folder) + '/' + texture_prefix + digits + type;
    to_.textures.push_back({path, std::string(begin, begin + bytes)});
    return path;
  }

  const gltf::GltfFile& file_;
  SurfaceObjects& to_;
  std::vector<std::size_t> materials_;  // indices in the file of SurfaceObjects::materials
  std::map<std::tuple<std::uint64_t, std::uint64_t, std::string>, std::string>
      path_of_;  // of a view and a type
  std::uint64_t bytes_left_ = file_.binary.size();
  UniqueNames names_, identifiers_;
};

// The file's normals, transformed by skinning into the bind pose.
void append_normals(std::vector<float>& normals, const gltf::RigPart& part,
                    const std::vector<Matrix4d>& bind) {
  std::vector<Matrix4d> slots;
  for (std::size_t k = 0; k < part.skin_joint.size(); ++k)
    slots.push_back(bind.at(part.skin_joint[k]) * part.inverse_bind[k]);
  for (std::size_t i = 0; i < part.positions.size(); ++i) {
    Vector3d normal = part.normals.empty() ? Vector3d::Zero() : part.normals[i];
    if (!part.influence_offset.empty() && !part.normals.empty()) {
      Matrix4d blend = Matrix4d::Zero();
      for (std::size_t k = part.influence_offset[i]; k < part.influence_offset[i + 1]; ++k)
        blend += part.weight[k] * slots[part.slot[k]];
      normal = blend.topLeftCorner<3, 3>().inverse().transpose() * normal;
    }
    const double length = normal.norm();
    const bool has_one = length > 0.0 && normal.allFinite();
    for (int axis = 0; axis < 3; ++axis)
      normals.push_back(has_one ? static_cast<float>(normal[axis] / length) : 0.0f);
  }
}

// The index of a primitive's material in the file, if it has one.
const json* material_of(const json& document, const gltf::RigPart& part) {
  const json* mesh = entry(document, "meshes", json(std::size_t{part.mesh}));
  if (mesh == nullptr) return nullptr;
  const json& primitive = mesh->at("primitives").at(part.primitive);
  const auto number = primitive.find("material");
  return number != primitive.end() && entry(document, "materials", *number) != nullptr ? &*number : nullptr;
}

class Reader {
 public:
  Reader(const model::Model& model, const fs::path& path)
      : model_(model),
        path_(path),
        file_(gltf::read_gltf_file(path)),
        character_(gltf::read_gltf(path)),
        rig_(gltf::read_rig(path)),
        looks_(file_, result_) {}

  SurfaceObjects run() {
    check();
    std::vector<Matrix4d> bind;
    for (const rig::Joint& joint : character_.skeleton) bind.push_back(joint.inverse_bind.inverse());
    for (std::size_t p = 0; p < rig_.parts.size(); ++p) {
      if (p == 0 || rig_.parts[p].node != rig_.parts[p - 1].node) begin_object(p);
      add_part(p);
      append_normals(result_.normals, rig_.parts[p], bind);
    }
    if (std::all_of(result_.normals.begin(), result_.normals.end(), [](float n) { return n == 0.0f; }))
      result_.normals.clear();
    return std::move(result_);
  }

 private:
  void check() const {
    std::size_t vertices = 0, triangles = 0;
    bool same = rig_.parts.size() == character_.parts.size();
    for (std::size_t p = 0; same && p < rig_.parts.size(); ++p) {
      const rig::SurfacePart& part = character_.parts[p];
      same = part.first_vertex == vertices && part.vertex_count == rig_.parts[p].positions.size() &&
             part.first_triangle == triangles;
      vertices += part.vertex_count;
      triangles += part.triangle_count;
    }
    same = same && 3 * triangles == model_.surface_triangle.size();
    for (std::size_t p = 0; same && p < rig_.parts.size(); ++p) {
      const rig::SurfacePart& part = character_.parts[p];
      const auto first = model_.surface_triangle.begin() + std::ptrdiff_t{3} * part.first_triangle;
      same = std::all_of(first, first + std::ptrdiff_t{3} * part.triangle_count, [&](std::uint32_t v) {
        return v >= part.first_vertex && v - part.first_vertex < part.vertex_count;
      });
    }
    if (!same || vertices != model_.surface_count() || 3 * triangles != model_.surface_triangle.size())
      throw base::BakeError(path_.string() + ": has " + base::number_text(std::uint64_t{vertices}) +
                            " vertices, and the baked surface " + base::number_text(model_.surface_count()) +
                            "; bake again with --overwrite");
  }

  void begin_object(std::size_t p) {
    const rig::SurfacePart& part = character_.parts[p];
    SurfaceObject& object = result_.objects.emplace_back();
    object.name = names_.take(one_line(part.object));
    object.identifier = identifiers_.take(identifier_of(part.object));
    object.first_vertex = part.first_vertex;
  }

  void add_part(std::size_t p) {
    const rig::SurfacePart& part = character_.parts[p];
    SurfaceObject& object = result_.objects.back();
    const auto first = static_cast<std::uint32_t>(object.triangle.size() / 3);
    for (std::uint32_t i = 3 * part.first_triangle; i < 3 * (part.first_triangle + part.triangle_count); ++i)
      object.triangle.push_back(model_.surface_triangle[i] - object.first_vertex);
    if (const json* number = material_of(file_.document, rig_.parts[p])) {
      const std::uint32_t material = looks_.material(number->get<std::size_t>());
      auto set = std::find_if(object.face_sets.begin(), object.face_sets.end(),
                              [&](const FaceSet& each) { return each.material == material; });
      if (set == object.face_sets.end())
        set = object.face_sets.insert(object.face_sets.end(), {.material = material, .triangles = {}});
      for (std::uint32_t t = 0; t < part.triangle_count; ++t) set->triangles.push_back(first + t);
    }
    const auto& uvs = rig_.parts[p].uvs;
    if (!uvs.empty()) {
      // Earlier parts of the object may have no texture coordinates.
      object.uvs.resize(std::size_t{2} * object.vertex_count, 0.0f);
      for (const Eigen::Vector2d& uv : uvs) {
        object.uvs.push_back(static_cast<float>(uv[0]));
        object.uvs.push_back(static_cast<float>(1.0 - uv[1]));  // glTF's v points down
      }
    } else if (!object.uvs.empty()) {
      object.uvs.resize(object.uvs.size() + std::size_t{2} * part.vertex_count, 0.0f);
    }
    object.vertex_count += part.vertex_count;
  }

  const model::Model& model_;
  const fs::path& path_;
  const gltf::GltfFile file_;
  const rig::Character character_;
  const gltf::Rig rig_;
  SurfaceObjects result_;
  Looks looks_;
  UniqueNames names_, identifiers_;
};

}  // namespace

bool is_opaque(const SurfaceMaterial& material) {
  return material.alpha_mode == gltf::AlphaMode::opaque ||
         (material.alpha_mode == gltf::AlphaMode::mask && material.alpha_cutoff == 0.0);
}

double opacity_of(const SurfaceMaterial& material) {
  return is_opaque(material) ? 1.0 : material.alpha;
}

bool is_texture_name(const std::string& name) {
  if (!name.starts_with(texture_prefix) || !(name.ends_with(".png") || name.ends_with(".jpg"))) return false;
  const std::size_t first = std::string_view(texture_prefix).size();
  const std::string digits = name.substr(first, name.size() - first - 4);
  return digits.size() >= 3 &&
         std::all_of(digits.begin(), digits.end(), [](char c) { return c >= '0' && c <= '9'; });
}

SurfaceObjects read_surface_objects(const model::Model& model, const fs::path& character) {
  if (!character.empty()) return Reader(model, character).run();
  SurfaceObjects one;
  one.objects.push_back({.name = "surface",
                         .identifier = "surface",
                         .first_vertex = 0,
                         .vertex_count = static_cast<std::uint32_t>(model.surface_count()),
                         .triangle = model.surface_triangle,
                         .face_sets = {},
                         .uvs = {}});
  return one;
}

std::shared_ptr<const SurfaceObjects> objects_of(const BakeInfo& info) {
  if (info.objects) return info.objects;
  return std::make_shared<const SurfaceObjects>(read_surface_objects(*info.model, info.character));
}

void write_textures(const fs::path& folder, const SurfaceObjects& surface) {
  if (surface.textures.empty()) return;
  base::make_own_folder(folder / textures_folder);
  for (const SurfaceTexture& texture : surface.textures)
    base::write_whole(folder / texture.file, texture.bytes);
}

std::string identifier_of(std::string_view name) {
  std::string result;
  for (const char c : name) {
    const bool is_letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
    const bool is_digit = c >= '0' && c <= '9';
    if (is_digit && result.empty()) result += '_';
    result += is_letter || is_digit ? c : '_';
  }
  return result.empty() ? "_" : result;
}

std::span<const float> values_of(const SurfaceObject& object, std::span<const float> surface,
                                 std::size_t width) {
  return surface.subspan(width * object.first_vertex, width * object.vertex_count);
}

}  // namespace fascicle::formats
