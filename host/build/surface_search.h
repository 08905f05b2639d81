// Questions about a point and a surface of triangles, each answered in about the logarithm of the triangles'
// number: the nearest place, the distance, inside or outside.
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
  double distance = 0.0;  // from the point asked about, m
};

// The place of a triangle nearest to a point; a triangle without area is a segment or a point. `triangle` is
// left 0.
SurfacePoint nearest_on_triangle(const scene::Vector3d& point, const scene::Vector3d& a,
                                 const scene::Vector3d& b, const scene::Vector3d& c);

class SurfaceSearch {
 public:
  // The surface must outlive it and have a triangle; corners in range, coordinates finite.
  explicit SurfaceSearch(const mesh::SurfaceMesh& surface);

  // Of triangles at the same computed distance the one of the lowest number.
  SurfacePoint nearest(const scene::Vector3d& point) const;

  // Whether the surface comes nearer than `distance`; faster than asking for the nearest place.
  bool is_nearer_than(const scene::Vector3d& point, double distance) const;

  // Whether a point lies inside a closed surface, by the majority of three rays: inside is where a ray
  // crosses an odd number of triangles, so their facing does not matter, and where two parts overlap is
  // outside.
  bool is_inside(const scene::Vector3d& point) const;

  // Calls visit(triangle, is_outward) for each triangle that a ray crosses: outward where it leaves through
  // the face. No component of the direction may be 0.
  void for_each_crossing(const scene::Vector3d& origin, const scene::Vector3d& direction,
                         const std::function<void(std::uint32_t, bool)>& visit) const;

  // How often a closed surface goes round a point, the middle one of three rays' answers: 1 inside, 0
  // outside, 2 where it overlaps itself; negative where triangles face inward.
  int winding(const scene::Vector3d& point) const;

 private:
  // Triangles that a ray crosses, and how many more of them from inside than from outside.
  struct Crossings {
    int all = 0;
    int outward = 0;
  };
  Crossings crossings(const scene::Vector3d& origin, const scene::Vector3d& direction) const;

  const mesh::SurfaceMesh& surface_;
  BoxTree tree_;
};

}  // namespace fascicle::build
