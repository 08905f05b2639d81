// The parent's side of fascicle-mesher.
#pragma once

#include "host/build/build.h"
#include "host/scene/scene.h"

namespace fascicle::build {

// Fills a closed surface, of any number of parts beside each other, with tetrahedra of positive volume. The
// surface's vertices come first and unchanged, its triangles are the boundary; it may be inside out. Then
// come the points of `inside`, in order, without those that lie outside or on another vertex, then new
// vertices; all are used. `edge` is the wanted mean edge (m; 0: the surface's mean edge); where the surface's
// own triangles are larger, it stays larger. Runs the helper process under the options' limits and checks
// what comes back. Throws scene::SceneError: one message a failure (not found, not closed, self-intersecting,
// out of memory, out of time, crashed, empty result).
mesh::TetMesh tetrahedralize(const mesh::SurfaceMesh& surface, double edge,
                             const std::vector<scene::Vector3d>& inside, const BuildOptions& options);

}  // namespace fascicle::build
