// A closed surface around any surface: CGAL's 3D alpha wrapping, remeshed to triangles of uniform size.
#pragma once

#include <cstddef>
#include <optional>

#include "host/mesher/files.h"

namespace fascicle::mesher {

struct WrapSettings {
  double alpha = 0.0;   // gaps and holes narrower than about twice this are closed: a ball's radius
  double offset = 0.0;  // distance of the wrap outside the surface
  // Triangle size: edges of about `edge`, or such that the surface, filled with tetrahedra of the same edge,
  // has about `vertices` vertices in total. Neither: the wrap as CGAL makes it.
  std::optional<double> edge;
  std::optional<std::size_t> vertices;
};

struct Wrap {
  Surface surface;
  double alpha = 0.0, offset = 0.0;  // those used: larger than asked for if such triangles cross there
};

// Wraps any set of triangles: open, intersecting, in parts, with any orientation. The result is closed,
// consistently faces outward, and does not intersect itself. Throws Failure (wrap_failed) if there is no such
// result.
Wrap wrap(const Surface& surface, const WrapSettings& settings);

}  // namespace fascicle::mesher
