// Small surfaces and skeletons for the build tests.
#pragma once

#include <string>

#include "host/scene/scene.h"

namespace fascicle::tests {

// A cube around the origin, facing outward, 8 vertices and 12 triangles.
inline mesh::SurfaceMesh cube_surface(double side) {
  mesh::SurfaceMesh cube;
  for (int k = 0; k < 8; ++k)
    cube.vertices.push_back(0.5 * side * scene::Vector3d(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1));
  cube.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return cube;
}

// A joint at `place`, without rotation in the bind pose.
inline rig::Joint joint_at(const std::string& name, std::int32_t parent, const scene::Vector3d& place) {
  rig::Joint joint;
  joint.name = name;
  joint.parent = parent;
  joint.inverse_bind.block<3, 1>(0, 3) = -place;
  joint.skins = true;
  return joint;
}

}  // namespace fascicle::tests
