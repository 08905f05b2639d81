// A body of our own without a skeleton: something to drop.
#pragma once

#include <string>
#include <vector>

#include "host/mesh/mesh.h"

namespace fascicle::made {

// "bunny": a sitting bunny of 0.34 m with its ears, looking to +z; its soles stand at y = 0.
std::vector<std::string> made_surface_names();

// Throws SceneError for any other name.
mesh::SurfaceMesh make_surface(const std::string& name);

}  // namespace fascicle::made
