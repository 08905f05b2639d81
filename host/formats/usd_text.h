// Parts of USD's text format.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "host/formats/surface_objects.h"

namespace fascicle::formats {

// A line, indented by `level` times four spaces.
std::string usd_line(int level, const std::string& text);
// The text, quoted.
std::string usd_string(const std::string& text);
// [(x, y, z), ...], `width` values each.
std::string usd_tuples(std::span<const float> values, std::size_t width);
std::string usd_numbers(std::span<const std::uint32_t> values);

// The scope with all materials, and the path of a material in it.
std::string usd_materials(const SurfaceObjects& surface, const std::string& path, int level);
std::string usd_material_path(const SurfaceMaterial& material, const std::string& path);

// Material bindings of an object: for the whole mesh, or for its faces as GeomSubsets. `properties` go before
// the mesh's child prims; `subsets` are prims.
struct UsdBinding {
  std::string properties, subsets;
};
UsdBinding usd_binding(const SurfaceObjects& surface, const SurfaceObject& object, const std::string& path,
                       int level);

// The text of a mesh before and after its points: name, topology, materials, texture coordinates. `schemas`:
// additional API schemas, such as "SkelBindingAPI"; empty: none.
struct UsdMesh {
  std::string head, tail;
};
UsdMesh usd_mesh(const SurfaceObjects& surface, const SurfaceObject& object, const std::string& materials,
                 const std::string& schemas, int level);

}  // namespace fascicle::formats
