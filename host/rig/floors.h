// Floors and walls in a character's file. They say nothing about the size of the body on them.
#pragma once

#include <vector>

#include "host/rig/character.h"

namespace fascicle::rig {

// Per vertex of the surface: whether it is on a floor or wall, a flat part that is connected to no other part
// (vertices at the same place are connected), is moved by one joint (each vertex by at least 0.99 of its
// weights), is more than twice as long as all other parts together, and has the middle of these within its
// box along its two longest axes. None if there is no other part, or if the character is not complete yet.
// Whether skeleton.simulated makes the part flesh is not known here.
std::vector<char> on_floors(const Character& character);

}  // namespace fascicle::rig
