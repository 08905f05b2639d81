// Closes the open ends of a skin, so that its inside is solid: a trouser leg that ends under a skirt, a neck
// that ends in a collar. A wrap would otherwise enter there and leave walls as thick as a triangle, without
// bone.
//
// An end is a loop of edges that have an odd number of triangles. It is closed by the triangulation of least
// area. Two kinds stay open. One is the outline of a sheet, such as a cape or a lock of hair: closing it
// would add almost the sheet's own area again. The other is a hem around several complete limbs, such as a
// skirt around legs: a lid would join them. If one of these limbs also has an open end inside, the limb
// continues in what hangs around it, and the hem is closed.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/build/build.h"
#include "host/build/limbs.h"
#include "host/scene/scene.h"

namespace fascicle::build {

struct OpenEnd {
  enum class Fate : std::uint8_t { closed, sheet, hem };
  std::vector<std::uint32_t> loop;                      // vertices of the skin, once around
  std::vector<std::array<std::uint32_t, 3>> triangles;  // the lid; corners are vertices of the skin
  Fate fate = Fate::closed;
  double width = 0.0;  // m: between the two vertices of the loop that are farthest apart
};

// The open ends of a welded skin, by their lowest vertex. Throws Cancelled.
std::vector<OpenEnd> find_open_ends(const mesh::SurfaceMesh& skin, const Limbs& limbs,
                                    const BuildOptions& options = {});

// The skin followed by the triangles that close its ends.
mesh::SurfaceMesh with_caps(const mesh::SurfaceMesh& skin, const std::vector<OpenEnd>& ends);

}  // namespace fascicle::build
