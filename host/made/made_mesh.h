// Improves closed triangle meshes.
#pragma once

#include <cstdint>
#include <vector>

#include "host/rig/character.h"

namespace fascicle::made {

using Eigen::Vector3d;

// The vertices that share an edge with each vertex, ascending.
std::vector<std::vector<std::uint32_t>> vertex_neighbours(const mesh::SurfaceMesh& mesh);

// Flips edges of a closed, manifold mesh until the two angles opposite each edge sum to at most 180 degrees,
// up to rounding. Keeps the mesh manifold and turns no face by more than 60 degrees.
void flip_to_delaunay(mesh::SurfaceMesh& mesh);

// Moves each vertex most of the way to the mean of its neighbours, weighted by the area around them, within
// its tangent plane: dense vertices spread out.
void smooth_tangentially(mesh::SurfaceMesh& mesh);

}  // namespace fascicle::made
