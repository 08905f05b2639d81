// Floors and walls in a character's file, as the model knows them.
#pragma once

#include <vector>

#include "host/model/model.h"

namespace fascicle::model {

// Flat parts of the render mesh, connected to no other (vertices at the same place are connected), that only
// the skeleton moves, that are more than twice as long as all the rest of a body with flesh, and that have
// the middle of the rest within their box along its two longest axes. They may be far larger than the body:
// pictures that fit them would show it as a dot, and the tetrahedra that carry them would be most of its
// volume. Of several characters, the rest is all of them together.
struct Surroundings {
  std::vector<char> surface;   // per render vertex: whether it is on one
  std::vector<char> vertices;  // per model vertex: whether it carries one
};
Surroundings surroundings_of(const Model& model);

}  // namespace fascicle::model
