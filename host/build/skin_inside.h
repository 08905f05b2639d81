// Inside or outside a skin as artists draw it: in closed or open parts, layered over each other, like a body
// and its shirt. Ray parity says nothing there.
#pragma once

#include <cstdint>
#include <vector>

#include "host/build/surface_search.h"
#include "host/mesh/mesh.h"

namespace fascicle::build {

class SkinInside {
 public:
  // The surface must outlive this object and have a triangle; corners must be in range, coordinates finite.
  // Vertices at the same place are merged: seams do not separate parts.
  explicit SkinInside(const mesh::SurfaceMesh& surface);

  // Whether the whole skin, or one connected part of it, encloses the point by more than half, by its winding
  // number. An open part counts by the share of directions it covers. A part that faces inward encloses
  // points too. The number is the mean over fixed directions; it is exact for closed parts.
  bool contains(const scene::Vector3d& point) const;

 private:
  SurfaceSearch search_;
  std::vector<std::uint32_t> part_of_triangle_;  // numbers are below the number of vertices
};

}  // namespace fascicle::build
