// The parent's side of fascicle-mesher.
#pragma once

#include "host/build/build.h"
#include "host/scene/scene.h"

namespace fascicle::build {

// Fills a closed surface with tetrahedra. The surface's vertices come first and unchanged, its triangles are kept.
// `edge` is the wanted edge length (m; 0: the surface's mean edge). `inside` are further points that must become vertices.
// Runs the helper process under the options' limits and checks what comes back. Throws scene::SceneError: one message a
// failure (not found, not closed, self-intersecting, out of memory, out of time, crashed, empty result).
scene::TetMesh tetrahedralize(const scene::SurfaceMesh& surface, double edge, const std::vector<scene::Vector3d>& inside,
                              const BuildOptions& options);

}  // namespace fascicle::build
