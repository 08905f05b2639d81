// The model's own numbering. Neighbours lie close together in memory, and 16 or 32 consecutive vertices have
// one-rings of about the same length.
#pragma once

#include <cstdint>
#include <vector>

#include "host/build/body.h"
#include "host/build/one_ring.h"

namespace fascicle::build {

// Slabs two spacings thick across the longest axis of the bounding box; in them, strips two spacings wide
// across the next axis; in those, order along the third. Then, in windows of 256, by decreasing degree. The
// spacing is the edge of the cube that a vertex fills on average. Element k is the old number of the vertex
// that becomes k.
std::vector<std::uint32_t> locality_order(const mesh::TetMesh& mesh, const OneRings& rings);

// Renumbers vertex order[k] to k everywhere. Tetrahedra keep their orientation, start with their lowest
// corners and are sorted, so that the result does not depend on their order in the input.
void renumber(Body& body, const std::vector<std::uint32_t>& order);

}  // namespace fascicle::build
