// Pieces of USD's text form.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "host/formats/surface_objects.h"

namespace fascicle::formats {

// A line, `level` times four spaces in.
std::string usd_line(int level, const std::string& text);
// In quotes.
std::string usd_string(const std::string& text);
// [(x, y, z), ...], `width` values each.
std::string usd_tuples(std::span<const float> values, std::size_t width);
std::string usd_numbers(std::span<const std::uint32_t> values);

// The scope of all materials, and the path of one below it.
std::string usd_materials(const SurfaceObjects& surface, const std::string& path, int level);
std::string usd_material_path(const SurfaceMaterial& material, const std::string& path);

// Which material an object shows, or which of its faces show which: bindings and GeomSubsets. The lines that
// stand before the mesh's other prims: `properties`; prims: `subsets`.
struct UsdBinding {
  std::string properties, subsets;
};
UsdBinding usd_binding(const SurfaceObjects& surface, const SurfaceObject& object, const std::string& path,
                       int level);

// A mesh up to its points, and from there on: name, topology, materials, texture coordinates. `schemas`: more
// of them, as in "SkelBindingAPI"; empty: none.
struct UsdMesh {
  std::string head, tail;
};
UsdMesh usd_mesh(const SurfaceObjects& surface, const SurfaceObject& object, const std::string& materials,
                 const std::string& schemas, int level);

}  // namespace fascicle::formats
