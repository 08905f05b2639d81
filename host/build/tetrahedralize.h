// The caller's side of fascicle-mesher.
#pragma once

#include "host/build/build.h"
#include "host/scene/scene.h"

namespace fascicle::build {

// Fills a closed surface with tetrahedra of positive volume. The surface may have several separate parts and
// may be inside out. Its vertices come first and unchanged, and its triangles are the boundary. Next come the
// points of `inside`, in order, except those outside or on another vertex, then new vertices; all are used.
// `edge` is the target mean edge (m; 0: the surface's mean edge); where the surface's own triangles are
// larger, the mean edge stays larger. Runs the helper process under the options' limits and checks its
// output. Throws scene::SceneError with one message per kind of failure (not found, not closed,
// self-intersecting, out of memory, out of time, crashed, empty result).
mesh::TetMesh tetrahedralize(const mesh::SurfaceMesh& surface, double edge,
                             const std::vector<scene::Vector3d>& inside, const BuildOptions& options);

}  // namespace fascicle::build
