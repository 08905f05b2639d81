// The bone layer of a character must hold together: what hangs on an island of bone swings by itself.
#pragma once

#include <vector>

#include "host/build/measures.h"
#include "host/build/one_ring.h"

namespace fascicle::build {

// Marks further vertices in `is_bone`. Along every bone, whatever its length, a way from the vertex at its
// one end to that at the other, near the axis and through vertices whose nearest bone it is. Then the marked
// vertices of each connected part of the mesh are connected by edges of it: along the shortest ways between
// the islands, where an edge counts more the farther it lies from the bone; ways longer than a tenth of the
// bounding box's diagonal are not taken. A vertex in `closed` is not marked and not passed.
//
// Islands are counted within each connected part of the mesh; what no flesh joins counts once.
struct BoneLayerReport {
  std::size_t islands_before = 0;
  std::size_t islands = 0;
  std::size_t added = 0;                     // vertices
  std::vector<std::uint32_t> without;        // bones, indices into Body::bones, that own no vertex
  std::vector<std::uint32_t> island_vertex;  // the lowest vertex of each island but its part's largest
};
BoneLayerReport complete_bone_layer(Measures& measures, const OneRings& rings,
                                    const std::vector<char>& closed, std::vector<char>& is_bone);

}  // namespace fascicle::build
