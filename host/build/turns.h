// How far the clips of a character turn its joints.
#pragma once

#include <vector>

#include "host/rig/character.h"

namespace fascicle::build {

// Of each joint the angle (radians, at most pi) between the two keys of one clip that are farthest apart,
// against the parent; 0 of those that no clip turns. Found from the key farthest from the first, so that it
// may be less than the whole where a joint turns about several axes. Between keys of a cubic spline a joint
// may turn further.
std::vector<double> turns_in_clips(const rig::Character& character);

}  // namespace fascicle::build
