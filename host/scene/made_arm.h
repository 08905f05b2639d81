// The arm and its clip; see made_character.h.
#pragma once

#include "host/scene/scene.h"

namespace fascicle::scene {

// Bound with the elbow bent by `bind_degrees`.
Character make_arm(double bind_degrees);

}  // namespace fascicle::scene
