// Skin weights of the body: the artist's on the skin, harmonic inside.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/base/parallel.h"
#include "host/build/body.h"
#include "host/build/body_mesh.h"

namespace fascicle::build {

// The artist's weights on the welded skin of `count` vertices. `welded` maps the character's vertices to it;
// a welded vertex takes the mean of the vertices merged into it. Throws scene::SceneError for weights that
// are negative, not finite or all 0, and for joints that do not exist.
SkinWeights welded_skin_weights(const rig::Character& character, std::span<const std::uint32_t> welded,
                                std::size_t count, const std::string& source);

// Vertices that all have the same weights: joints and what each holds.
struct SharedRow {
  std::vector<std::uint32_t> vertices;
  std::vector<std::pair<std::uint32_t, double>> row;
};

// `weights`, but with these vertices' shared rows, which are truncated and rounded as below.
SkinWeights with_shared_rows(const SkinWeights& weights, std::span<const SharedRow> shared);

// The weights of a tetrahedral mesh from those `given` at some of its vertices; the rows of the others are
// empty or, at the end, missing. The others take, joint by joint, the solution of Laplace's equation. Finite
// elements on arbitrary tetrahedra undershoot, so negative weights become 0. Shares below 1e-4 are dropped
// and at most 8 are kept; these sum to 1 in floats without rounding (multiples of 2^-23). Joints are solved
// in parallel; the result does not depend on the number of threads.
SkinWeights harmonic_skin_weights(const mesh::TetMesh& mesh, const SkinWeights& given,
                                  std::size_t joint_count, const std::string& source,
                                  std::size_t threads = base::thread_count());

// The weights of a body from those of the welded skin it was made from: a kept skin's unchanged, the boundary
// of a cage's from its anchors on the skin, and those inside as above.
SkinWeights body_skin_weights(const BodyMesh& body, const WeldedSurface& welded, const SkinWeights& skin,
                              std::size_t joint_count, const std::string& source);

}  // namespace fascicle::build
