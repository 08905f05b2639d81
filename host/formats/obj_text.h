// Parts of Wavefront OBJ and MTL files of a render surface.
#pragma once

#include <cstdint>
#include <string>

#include "host/formats/surface_objects.h"

namespace fascicle::formats {

// A name as one word.
std::string obj_name(const std::string& name);

// MTL text for all materials. Kd is the linear base colour; map_Kd is `to_folder` followed by the texture's
// file.
std::string mtl_text(const SurfaceObjects& surface, const std::string& to_folder);

// An object's vt lines; empty if it has no texture coordinates.
std::string obj_uvs(const SurfaceObject& object);

// An object's usemtl and f lines; vertex numbers are those of the whole surface. `uvs_before`: vt lines of
// earlier objects. With normals, each corner's normal has the same number as its vertex.
std::string obj_faces(const SurfaceObjects& surface, const SurfaceObject& object, std::uint64_t uvs_before,
                      bool with_normals);

}  // namespace fascicle::formats
