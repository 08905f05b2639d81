// Joins the bodies of several characters into one. Each is filled separately, exactly as it would be alone:
// the fill, the cuts between its limbs and its choice of bones never see the others.
#pragma once

#include "host/build/body.h"

namespace fascicle::build {

// The scene as it is for character number k alone: its skeleton settings name only that character's joints.
scene::Scene scene_of_character(const scene::Scene& scene, std::size_t k);

// Whether all flesh of character number k follows its skeleton: it is rigid, or skeleton.only names only
// others.
bool is_rigid(const scene::Scene& scene, std::size_t k);

// Appends `one`, the body of character number k, to those before it.
void append_body(const scene::Scene& scene, std::size_t k, Body one, Report found, Body& all, Report& report);

}  // namespace fascicle::build
