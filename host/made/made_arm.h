// The arm and its clip; see made_character.h.
#pragma once

#include "host/rig/character.h"

namespace fascicle::made {

// Bind pose with the elbow bent by `bind_degrees`.
rig::Character make_arm(double bind_degrees);

}  // namespace fascicle::made
