// Parametric bars.
#pragma once

#include <string>

#include "host/scene/scene.h"

namespace fascicle::build {

// A box from the origin to bar.size, six Kuhn tetrahedra a cell, all of positive volume. Vertex (x, y, z) of
// the grid has the number (x ny + y) nz + z; further bars follow, each bar.gap above the one before. Jitter
// moves vertices that lie strictly inside, by a generator of our own, so that a seed means the same mesh on
// every machine; a displacement that would squash a tetrahedron is halved until it does not. Throws
// scene::SceneError for sizes and counts that make no bar; `source` begins the message.
mesh::TetMesh make_bar(const scene::Bar& bar, const std::string& source);

}  // namespace fascicle::build
