// Points along the bones, for the tetrahedral mesh.
#pragma once

#include <vector>

#include "host/build/body.h"

namespace fascicle::build {

// Points along the bones about `spacing` apart, inside the surface and at least half of `spacing` from it and
// from each other. Without them the vertices near the bones would be islands.
std::vector<Vector3d> points_along_bones(const std::vector<Bone>& bones, const mesh::SurfaceMesh& surface,
                                         double spacing);

}  // namespace fascicle::build
