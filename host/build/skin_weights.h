// Skin weights of the body: the artist's on the skin, harmonic inside.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "host/base/parallel.h"
#include "host/build/body.h"
#include "host/build/body_mesh.h"

namespace fascicle::build {

// The artist's weights on the welded skin of `count` vertices; `welded` leads from the character's vertices
// to them, and a welded vertex takes the mean of the vertices it was made of. Throws scene::SceneError for
// weights that are negative, not finite or all 0, and for joints that are not there.
SkinWeights welded_skin_weights(const rig::Character& character, std::span<const std::uint32_t> welded,
                                std::size_t count, const std::string& source);

// The weights of a tetrahedral mesh from those `given` at some of its vertices; the rows of others are empty
// or, at the end, missing. These take, joint by joint, the solution of Laplace's equation. Finite elements on
// any tetrahedra undershoot, so negative weights become 0; shares below 1e-4 are dropped, at most 8 kept, and
// the rest sums to 1 in floats without rounding (multiples of 2^-23). Joints are solved for in parallel; the
// result does not depend on the number of threads.
SkinWeights harmonic_skin_weights(const mesh::TetMesh& mesh, const SkinWeights& given,
                                  std::size_t joint_count, const std::string& source,
                                  std::size_t threads = base::thread_count());

// The weights of a body from those of the welded skin that it was made from: a kept skin's as they are, the
// boundary of a cage's from its anchors on the skin, and inside as above.
SkinWeights body_skin_weights(const BodyMesh& body, const WeldedSurface& welded, const SkinWeights& skin,
                              std::size_t joint_count, const std::string& source);

}  // namespace fascicle::build
