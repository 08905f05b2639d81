// Characters generated in code: skeleton, skin, weights and clips.
#pragma once

#include <string>
#include <vector>

#include "host/rig/character.h"

namespace fascicle::made {

// "bear": a portly bear of 1.6 m that stands on its hind legs, in an A pose, facing +z; clip "jump", with
// anticipation and landing, and clip "bump", with the belly. "arm": an arm along +x, starting at the
// shoulder, palm up, straight; clip "curl" bends the elbow from straight to 160 degrees and back. "arm-bent"
// is the same, bound with its elbow at 46 degrees.
std::vector<std::string> made_character_names();

// Throws SceneError for any other name.
rig::Character make_character(const std::string& name);

}  // namespace fascicle::made
