// A skeleton's bones as line segments, and points along them for the tetrahedral mesh.
#pragma once

#include <string>
#include <vector>

#include "host/build/body.h"

namespace fascicle::build {

// In the bind pose, metres: from each joint that skins to each of the next joints below it that do; a joint
// that ends a chain, or whose next joints lie in its own place, gives a segment of length zero. Coordinates
// are multiplied by `scale`. Throws scene::SceneError for an inverse bind matrix that has no inverse, naming
// the joint.
std::vector<Bone> skeleton_bones(const std::vector<scene::Joint>& skeleton, double scale,
                                 const std::string& source);

// Points along the bones about `spacing` apart, half of it or more from each other and from the surface, and
// inside it. Without them the vertices near the bones would be islands.
std::vector<Vector3d> points_along_bones(const std::vector<Bone>& bones, const scene::SurfaceMesh& surface,
                                         double spacing);

}  // namespace fascicle::build
