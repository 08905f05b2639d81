// Parametric bars.
#pragma once

#include <string>

#include "host/scene/scene.h"

namespace fascicle::build {

// A box from the origin to bar.size, with six Kuhn tetrahedra per cell, all of positive volume. Grid vertex
// (x, y, z) has number (x ny + y) nz + z. Further bars follow, each bar.gap above the one before. Jitter
// moves interior vertices, using our own generator, so that a seed gives the same mesh on every machine. A
// displacement that would squash a tetrahedron is halved until it does not. Throws scene::SceneError for
// sizes and counts that make no bar; `source` begins the message.
mesh::TetMesh make_bar(const scene::Bar& bar, const std::string& source);

}  // namespace fascicle::build
