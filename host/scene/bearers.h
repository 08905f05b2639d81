// Characters that go with a joint of another one, as a sword with a hand: character.NAME.joint.
#pragma once

#include <vector>

#include "host/scene/scene.h"
#include "host/scene/toml.h"

namespace fascicle::scene {

// Moves characters behind those whose joints they go with, and keeps the file's order otherwise. Throws
// SceneError for a joint that no other character has, and for characters that go with each other.
void put_bearers_first(const toml::table& root, Scene& scene);

// Where the character stands, and by what: `held` is what its `at` and `turn` say. Those before it are
// placed.
void place(const std::vector<PlacedCharacter>& characters, const Eigen::Matrix4d& held,
           PlacedCharacter& character);

}  // namespace fascicle::scene
