// The bone layer of a character must hold together: what hangs on an island of bone swings by itself.
#pragma once

#include <vector>

#include "host/build/measures.h"
#include "host/build/one_ring.h"

namespace fascicle::build {

// Marks further vertices in `is_bone` so that every bone is the nearest one of some marked vertex, and that
// the marked vertices of each connected part of the mesh are connected by edges of it: along the shortest
// ways between the islands, where an edge counts more the farther it lies from the bone. A vertex in `closed`
// is not marked and not passed. Ways longer than a tenth of the bounding box's diagonal are not taken.
struct BoneLayerReport {
  std::size_t islands_before = 0;
  std::size_t islands = 0;
  std::size_t added = 0;                     // vertices
  std::vector<std::uint32_t> without;        // bones, indices into Body::bones, that own no vertex
  std::vector<std::uint32_t> island_vertex;  // the lowest vertex of each island but the largest
};
BoneLayerReport complete_bone_layer(Measures& measures, const OneRings& rings,
                                    const std::vector<char>& closed, std::vector<char>& is_bone);

}  // namespace fascicle::build
