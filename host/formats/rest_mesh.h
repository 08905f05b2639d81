// rest.obj: the mesh that the point caches (pc2, mdd) animate.
#pragma once

#include <filesystem>
#include <string>

#include "host/formats/surface_objects.h"
#include "host/model/model.h"

namespace fascicle::formats {

inline constexpr const char* rest_name = "rest.obj";
inline constexpr const char* rest_materials_name = "rest.mtl";

// Wavefront OBJ of the render mesh at rest (characters: in the bind pose), in its vertex order, metres, Y up.
// A single mesh, because a cache animates one; objects become groups. Includes texture coordinates and
// materials.
std::string rest_obj(const model::Model& model, const SurfaceObjects& surface);

// Writes rest.obj and, if there are materials, rest.mtl and its textures.
void write_rest_mesh(const std::filesystem::path& folder, const model::Model& model,
                     const SurfaceObjects& surface);

}  // namespace fascicle::formats
