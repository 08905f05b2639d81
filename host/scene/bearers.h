// Characters attached to a joint of another one, such as a sword in a hand: character.NAME.joint.
#pragma once

#include <vector>

#include "host/scene/scene.h"
#include "host/scene/toml.h"

namespace fascicle::scene {

// Reorders the characters so that each comes after the one that carries it; otherwise keeps the file's order.
// Throws SceneError if no other character has the joint, or if characters carry each other in a cycle.
void put_bearers_first(const toml::table& root, Scene& scene);

// Sets the character's place and bearer. `held` is the transform given by its `at` and `turn`. All characters
// before it must have been placed.
void place(const std::vector<PlacedCharacter>& characters, const Eigen::Matrix4d& held,
           PlacedCharacter& character);

}  // namespace fascicle::scene
