// A skin with sides no longer than a cage's edges, for what is decided place by place.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/build/body_mesh.h"

namespace fascicle::build {

struct RefinedSkin {
  scene::SurfaceMesh surface;  // the skin's vertices first, in its order
  SkinWeights weights;         // empty where the skin's are; rows may be longer than 8
  // Of each triangle, the skin's triangle that it is part of, and its corners as weighted means of that
  // one's.
  std::vector<std::uint32_t> parent;
  std::vector<std::array<std::array<double, 3>, 3>> corners;

  // The same point on the skin itself.
  SkinPoint on_skin(const SkinPoint& point) const;
};

// Halves sides that are longer than `longest` (m), of all triangles at them, until none is or they are a
// 64th.
RefinedSkin refine_skin(const scene::SurfaceMesh& skin, const SkinWeights& weights, double longest);

}  // namespace fascicle::build
