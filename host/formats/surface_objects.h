// What the render surface is made of: its objects and materials with their names, its texture coordinates and
// the file's own normals. Every format that can name them takes them from here.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "host/formats/sink.h"
#include "host/model/model.h"

namespace fascicle::formats {

struct SurfaceMaterial {
  std::string name;                            // as in the file, made unique; "material N" where it has none
  std::string identifier;                      // the name in letters, digits and _, unique
  std::array<double, 3> color{1.0, 1.0, 1.0};  // of the base, linear
  double alpha = 1.0, metallic = 1.0, roughness = 1.0;
  std::array<double, 3> emission{};
  bool double_sided = false;
  std::string texture = {};  // of the base colour: its file, "textures/image_000.png"; empty: none
};

// The triangles of an object that show one material.
struct FaceSet {
  std::uint32_t material = 0;
  std::vector<std::uint32_t> triangles;  // numbers in the object
};

// A node of the file with its meshes, or the whole surface where there is no file.
struct SurfaceObject {
  std::string name;                                  // as in the file, made unique; without /
  std::string identifier;                            // the name in letters, digits and _, unique
  std::uint32_t first_vertex = 0, vertex_count = 0;  // a stretch of the surface's
  std::vector<std::uint32_t> triangle;               // 3 a triangle, vertices counted from the object's first
  std::vector<FaceSet> face_sets;                    // no set holds triangles without material
  std::vector<float> uvs;                            // 2 a vertex, v up; empty: none
};

struct SurfaceTexture {
  std::string file;  // "textures/image_000.png"
  std::string bytes;
};

struct SurfaceObjects {
  std::vector<SurfaceObject> objects;  // at least one; together the surface, in its order
  std::vector<SurfaceMaterial> materials;
  std::vector<SurfaceTexture> textures;
  std::vector<float> normals;  // the file's, in the model's rest pose: see SurfaceNormals
};

inline constexpr const char* textures_folder = "textures";
bool is_texture_name(const std::string& name);

// `character`: character.glb of the bake; empty: one object "surface". Throws BakeError where the file does
// not fit the model.
SurfaceObjects read_surface_objects(const model::Model& model, const std::filesystem::path& character);

// info.objects, or read anew where there are none.
std::shared_ptr<const SurfaceObjects> objects_of(const BakeInfo& info);

// FOLDER/textures with the images that the materials show; nothing where they show none.
void write_textures(const std::filesystem::path& folder, const SurfaceObjects& surface);

// Letters, digits and _, not beginning with a digit: all other bytes become _.
std::string identifier_of(std::string_view name);

// An object's values out of the surface's, `width` values a vertex.
std::span<const float> values_of(const SurfaceObject& object, std::span<const float> surface,
                                 std::size_t width = 3);

}  // namespace fascicle::formats
