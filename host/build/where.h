// Which vertices lie in the shapes of a scene.
#pragma once

#include <string>
#include <vector>

#include "host/build/measures.h"

namespace fascicle::build {

// Shape tests over one body. Bounds are inclusive up to 1e-9 of the bounding box's diagonal, so that a face
// at 0.4 m contains vertices that rounding put at 0.4 - 1e-17. Each of several characters is tested in its
// own bind pose.
class WhereTest {
 public:
  // The measures and their body must outlive this object.
  explicit WhereTest(Measures& measures);

  Measures& measures() { return measures_; }

  // One flag per vertex. Throws scene::SceneError, naming `key`, if a distance from bones is used without
  // bones, and for names that no joint or painted attribute has.
  std::vector<char> contains(const scene::Where& where, const std::string& key, const std::string& source);

 private:
  Measures& measures_;
  std::vector<Vector3d> low_, high_;  // for each of the body's members
  double slack_;
};

}  // namespace fascicle::build
