// Pieces of Wavefront OBJ and MTL files of a render surface.
#pragma once

#include <cstdint>
#include <string>

#include "host/formats/surface_objects.h"

namespace fascicle::formats {

// A name as one word.
std::string obj_name(const std::string& name);

// MTL of all materials: Kd is the base colour, linear; map_Kd is `to_folder` and the texture's file.
std::string mtl_text(const SurfaceObjects& surface, const std::string& to_folder);

// The vt lines of an object; nothing where it has none.
std::string obj_uvs(const SurfaceObject& object);

// The usemtl and f lines of an object, whose vertices have the numbers of the surface's. `uvs_before`: vt
// lines of the objects before it. With normals each corner names the normal of its vertex' number.
std::string obj_faces(const SurfaceObjects& surface, const SurfaceObject& object, std::uint64_t uvs_before,
                      bool with_normals);

}  // namespace fascicle::formats
