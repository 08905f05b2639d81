// Skin weights of the tetrahedral mesh: the artist's on the surface, harmonic inside.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "host/build/body.h"

namespace fascicle::build {

// The weights of a tetrahedral mesh whose first `surface_count` vertices are the character's welded ones.
// `welded` leads from the character's vertices to them; a welded vertex takes the mean of the vertices it was
// made of. The others take, joint by joint, the solution of Laplace's equation with the surface's weights as
// boundary values (linear finite elements, conjugate gradients to 1e-8). Finite elements on any tetrahedra
// undershoot, so negative weights become 0; shares below 1e-4 are dropped, at most 8 kept, and the rest sums
// to 1 in floats without rounding (multiples of 2^-23).
SkinWeights skin_weights(const scene::TetMesh& mesh, std::size_t surface_count,
                         const scene::Character& character, std::span<const std::uint32_t> welded,
                         const std::string& source);

}  // namespace fascicle::build
