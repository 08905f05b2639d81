// Mesh spacing.
#pragma once

#include "host/build/build.h"
#include "host/scene/scene.h"

namespace fascicle::build {

// The mean length of the edges at each vertex, which explicit stiffness depends on.
Spread vertex_spacing(const mesh::SurfaceMesh& surface);
Spread vertex_spacing(const mesh::TetMesh& mesh);

Spread edge_lengths(const mesh::TetMesh& mesh);

// The volume that a surface encloses, m^3; negative if it faces inward.
double enclosed_volume(const mesh::SurfaceMesh& surface);

}  // namespace fascicle::build
