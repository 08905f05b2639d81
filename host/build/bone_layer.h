// The bone layer of a character must be connected: flesh attached to an island of bone swings by itself.
#pragma once

#include <vector>

#include "host/build/measures.h"
#include "host/build/one_ring.h"

namespace fascicle::build {

// Marks further vertices in `is_bone`. First, for every bone, whatever its length, a path from the vertex at
// one end to the vertex at the other, near the axis and through vertices whose nearest bone it is. Then it
// connects the marked vertices within each connected part of the mesh, along the shortest paths of edges
// between the islands. An edge costs more the farther it lies from the bone; paths longer than a tenth of the
// bounding box's diagonal are not used. Vertices in `closed` are neither marked nor crossed.
//
// Islands are counted within each connected part of the mesh; unconnected parts do not add islands.
struct BoneLayerReport {
  std::size_t islands_before = 0;
  std::size_t islands = 0;
  std::size_t added = 0;                     // vertices
  std::vector<std::uint32_t> without;        // bones, indices into Body::bones, that own no vertex
  std::vector<std::uint32_t> island_vertex;  // lowest vertex of each island except its part's largest
};
BoneLayerReport complete_bone_layer(Measures& measures, const OneRings& rings,
                                    const std::vector<char>& closed, std::vector<char>& is_bone);

}  // namespace fascicle::build
