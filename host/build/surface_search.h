// Point queries on a triangle surface, each in roughly logarithmic time: the nearest place, the distance,
// inside or outside.
#pragma once

#include <array>
#include <cstdint>
#include <functional>

#include "host/build/box_tree.h"
#include "host/scene/scene.h"

namespace fascicle::build {

// A place on a surface: in `triangle`, at the weighted mean of its corners.
struct SurfacePoint {
  std::uint32_t triangle = 0;
  std::array<double, 3> weights{};  // not negative, sum to 1
  scene::Vector3d point;
  double distance = 0.0;  // from the query point, m
};

// The nearest place of a triangle to a point; a triangle without area is a segment or a point. Leaves
// `triangle` 0.
SurfacePoint nearest_on_triangle(const scene::Vector3d& point, const scene::Vector3d& a,
                                 const scene::Vector3d& b, const scene::Vector3d& c);

class SurfaceSearch {
 public:
  // The surface must outlive this object and have a triangle; corners must be in range, coordinates finite.
  explicit SurfaceSearch(const mesh::SurfaceMesh& surface);

  // Of triangles at the same computed distance, returns the one with the lowest number.
  SurfacePoint nearest(const scene::Vector3d& point) const;

  // Whether the surface comes nearer than `distance`; faster than finding the nearest place.
  bool is_nearer_than(const scene::Vector3d& point, double distance) const;

  // Whether a point lies inside a closed surface, by majority of three rays. A point is inside if a ray
  // crosses an odd number of triangles, so their orientation does not matter, and the overlap of two parts is
  // outside.
  bool is_inside(const scene::Vector3d& point) const;

  // Calls visit(triangle, is_outward) for each triangle that a ray crosses; is_outward if the ray leaves
  // through its front. No component of the direction may be 0.
  void for_each_crossing(const scene::Vector3d& origin, const scene::Vector3d& direction,
                         const std::function<void(std::uint32_t, bool)>& visit) const;

  // The winding number of a closed surface around a point, the median of three rays: 1 inside, 0 outside, 2
  // where it overlaps itself; negative if triangles face inward.
  int winding(const scene::Vector3d& point) const;

 private:
  // Triangles that a ray crosses, and how many more of them it crosses outward than inward.
  struct Crossings {
    int all = 0;
    int outward = 0;
  };
  Crossings crossings(const scene::Vector3d& origin, const scene::Vector3d& direction) const;

  const mesh::SurfaceMesh& surface_;
  BoxTree tree_;
};

}  // namespace fascicle::build
