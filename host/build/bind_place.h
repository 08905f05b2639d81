// Where the joints of a skeleton are in the bind pose.
#pragma once

#include <string>

#include "host/rig/character.h"
#include "host/scene/scene.h"

namespace fascicle::build {

// A joint's position in the bind pose, from its inverse bind matrix, times `scale`, m. Throws
// scene::SceneError, whose message begins with `source`, if the matrix has no inverse, or if the joint is so
// far away that nothing can be simulated.
scene::Vector3d bind_place(const rig::Joint& joint, double scale, const std::string& source);

}  // namespace fascicle::build
