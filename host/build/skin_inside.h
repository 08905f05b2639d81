// Inside or outside a skin as artists draw it: in parts, closed or open, one over the other, as a body and
// the shirt that it wears. There a ray that crosses an odd number of triangles says nothing.
#pragma once

#include <cstdint>
#include <vector>

#include "host/build/surface_search.h"
#include "host/mesh/mesh.h"

namespace fascicle::build {

class SkinInside {
 public:
  // The surface must outlive it and have a triangle; corners in range, coordinates finite. Vertices at the
  // same place are one: seams part nothing.
  explicit SkinInside(const mesh::SurfaceMesh& surface);

  // Whether the whole skin, or one connected part of it, goes around the point by more than half: by its
  // winding number, in which an open part counts by the share of all directions that it covers. A part that
  // faces inward goes around too. The number is the mean over fixed directions; of closed parts it is exact.
  bool contains(const scene::Vector3d& point) const;

 private:
  SurfaceSearch search_;
  std::vector<std::uint32_t> part_of_triangle_;  // a number below that of the vertices
};

}  // namespace fascicle::build
