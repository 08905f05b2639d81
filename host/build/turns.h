// How far the clips of a character turn its joints.
#pragma once

#include <vector>

#include "host/rig/character.h"

namespace fascicle::build {

// For each joint the angle (radians, at most pi) between the two keys of one clip that are farthest apart,
// relative to the parent; 0 for joints that no clip turns. The search starts from the key farthest from the
// first, so it may find less than the maximum if a joint turns about several axes. Between keys of a cubic
// spline a joint may turn farther.
std::vector<double> turns_in_clips(const rig::Character& character);

}  // namespace fascicle::build
