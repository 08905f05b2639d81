// A closed surface around any surface: CGAL's 3D alpha wrapping, remeshed to triangles of one size.
#pragma once

#include <cstddef>
#include <optional>

#include "host/mesher/files.h"

namespace fascicle::mesher {

struct WrapSettings {
  double alpha = 0.0;   // gaps and holes narrower than about this are closed over
  double offset = 0.0;  // how far outside the surface the wrap lies
  // Which triangles: sides of about `edge`, or such that the surface, filled with tetrahedra of the same
  // edge, has about `vertices` vertices in all. Neither: the wrap as CGAL makes it.
  std::optional<double> edge;
  std::optional<std::size_t> vertices;
};

// Surrounds all triangles, however they lie: open, crossing, in parts, facing any way. The result is closed,
// consistently facing outward, and does not cross itself. Throws Failure (wrap_failed) where there is no such
// result.
Surface wrap(const Surface& surface, const WrapSettings& settings);

}  // namespace fascicle::mesher
