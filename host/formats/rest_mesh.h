// rest.obj: what the point caches (pc2, mdd) ride on.
#pragma once

#include <filesystem>
#include <string>

#include "host/formats/surface_objects.h"
#include "host/model/model.h"

namespace fascicle::formats {

inline constexpr const char* rest_name = "rest.obj";
inline constexpr const char* rest_materials_name = "rest.mtl";

// Wavefront OBJ of the render mesh at rest (characters: in the bind pose), in its vertex order, metres, Y up.
// One mesh, for a cache moves one; its objects are its groups. With texture coordinates and materials.
std::string rest_obj(const model::Model& model, const SurfaceObjects& surface);

// rest.obj, and with materials rest.mtl and its textures.
void write_rest_mesh(const std::filesystem::path& folder, const model::Model& model,
                     const SurfaceObjects& surface);

}  // namespace fascicle::formats
