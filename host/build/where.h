// Which vertices lie in a scene's parts of space.
#pragma once

#include <cstdint>
#include <vector>

#include "host/build/body.h"

namespace fascicle::build {

// Shape tests over one body. Bounds are inclusive up to 1e-9 of the bounding box's diagonal, so that a face
// at 0.4 m holds the vertices that rounding put at 0.4 - 1e-17.
class WhereTest {
 public:
  // The body must outlive it.
  explicit WhereTest(const Body& body);

  // One flag a vertex. Throws scene::SceneError, naming `key`, where a bone distance is asked for and there
  // are no bones.
  std::vector<char> contains(const scene::Where& where, const std::string& key, const std::string& source);

  // Distance of each vertex to the nearest of its own bones, m: those that an owner with at least 2 % of the
  // vertex's weights moves, those the scene draws, or all where there is none. 0 for a vertex that joints at
  // the end of a chain move for the most part: heads, hands and feet have no bone inside that a distance
  // could be measured from, and follow the skeleton. Computed on first use.
  const std::vector<double>& bone_distances();

 private:
  const Body& body_;
  Vector3d low_, high_;
  double slack_;
  std::vector<double> bone_distances_;
};

// Distance from a point to a segment, m.
double segment_distance(const Vector3d& point, const Vector3d& from, const Vector3d& to);

}  // namespace fascicle::build
