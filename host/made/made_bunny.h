// A generated body without a skeleton: something to drop.
#pragma once

#include <string>
#include <vector>

#include "host/mesh/mesh.h"

namespace fascicle::made {

// "bunny": a sitting bunny, 0.34 m tall including its ears, looking to +z; its soles are at y = 0.
std::vector<std::string> made_surface_names();

// Throws SceneError for any other name.
mesh::SurfaceMesh make_surface(const std::string& name);

}  // namespace fascicle::made
