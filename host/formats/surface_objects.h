// The structure of the render surface: its objects and materials with their names, its texture coordinates
// and the file's own normals. Every format that supports names uses these.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/formats/sink.h"
#include "host/gltf/gltf_material.h"
#include "host/model/model.h"

namespace fascicle::formats {

struct SurfaceMaterial {
  std::string name;                            // as in the file, made unique; "material N" if it has none
  std::string identifier;                      // the name in letters, digits and _, unique
  std::array<double, 3> color{1.0, 1.0, 1.0};  // base colour, linear
  double alpha = 1.0, metallic = 1.0, roughness = 1.0;
  gltf::AlphaMode alpha_mode = gltf::AlphaMode::opaque;
  double alpha_cutoff = 0.5;                      // of AlphaMode::mask
  std::optional<std::array<double, 3>> specular;  // colour at normal incidence, where the file gives it
  std::array<double, 3> emission{};
  bool double_sided = false;
  std::string texture = {};  // base colour texture: its file, "textures/image_000.png"; empty: none
  gltf::TextureWrap wrap_across = gltf::TextureWrap::repeat, wrap_up = gltf::TextureWrap::repeat;
};

// Whether alpha has no effect.
bool is_opaque(const SurfaceMaterial& material);
// The opacity of a material without its texture.
double opacity_of(const SurfaceMaterial& material);

// An object's triangles that have the same material.
struct FaceSet {
  std::uint32_t material = 0;
  std::vector<std::uint32_t> triangles;  // indices into the object's triangles
};

// A node of the file with its meshes, or the whole surface if there is no file.
struct SurfaceObject {
  std::string name;                                  // as in the file, made unique; without /
  std::string identifier;                            // the name in letters, digits and _, unique
  std::uint32_t first_vertex = 0, vertex_count = 0;  // range in the surface
  std::vector<std::uint32_t> triangle;               // 3 per triangle, relative to the object's first vertex
  std::vector<FaceSet> face_sets;                    // triangles without a material are in none
  std::vector<float> uvs;                            // 2 per vertex, v up; empty: none
};

struct SurfaceTexture {
  std::string file;  // "textures/image_000.png"
  std::string bytes;
};

struct SurfaceObjects {
  std::vector<SurfaceObject> objects;  // at least one; in order, they make up the surface
  std::vector<SurfaceMaterial> materials;
  std::vector<SurfaceTexture> textures;
  std::vector<float> normals;  // the file's, in the model's rest pose; see SurfaceNormals
};

inline constexpr const char* textures_folder = "textures";
bool is_texture_name(const std::string& name);

// `character`: the bake's character.glb; empty: one object "surface". Throws BakeError if the file does not
// match the model.
SurfaceObjects read_surface_objects(const model::Model& model, const std::filesystem::path& character);

// info.objects, or read from the character if null.
std::shared_ptr<const SurfaceObjects> objects_of(const BakeInfo& info);

// Writes FOLDER/textures with the images that the materials use; nothing if they use none.
void write_textures(const std::filesystem::path& folder, const SurfaceObjects& surface);

// Letters, digits and _, not starting with a digit; all other bytes become _.
std::string identifier_of(std::string_view name);

// The object's part of the surface's values, `width` values per vertex.
std::span<const float> values_of(const SurfaceObject& object, std::span<const float> surface,
                                 std::size_t width = 3);

}  // namespace fascicle::formats
