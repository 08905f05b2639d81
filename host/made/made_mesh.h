// Closed triangle meshes made even.
#pragma once

#include <cstdint>
#include <vector>

#include "host/rig/character.h"

namespace fascicle::made {

using Eigen::Vector3d;

// The vertices that share an edge with each, ascending.
std::vector<std::vector<std::uint32_t>> vertex_neighbours(const mesh::SurfaceMesh& mesh);

// Flips edges of a closed, manifold mesh until, up to a rounding, each has opposite angles of at most 180
// degrees in sum, the mesh stays manifold and no flip turns a face by more than 60 degrees.
void flip_to_delaunay(mesh::SurfaceMesh& mesh);

// Moves each vertex most of the way to the mean of its neighbours, weighted by the area around them, along
// its tangent plane: where vertices are dense they spread.
void smooth_tangentially(mesh::SurfaceMesh& mesh);

}  // namespace fascicle::made
