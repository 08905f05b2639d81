// The bodies of several characters as one. Each is filled by itself, as it is alone: what fills it, cuts its
// limbs apart and chooses its bones never sees the others.
#pragma once

#include "host/build/body.h"

namespace fascicle::build {

// The scene as its character number k has it alone: what it says of a skeleton holds names of its joints
// only.
scene::Scene scene_of_character(const scene::Scene& scene, std::size_t k);

// Whether all flesh of character number k follows its skeleton: it is rigid, or skeleton.only names others.
bool is_rigid(const scene::Scene& scene, std::size_t k);

// Adds the body of character number k, which `one` says of, to those before it.
void append_body(const scene::Scene& scene, std::size_t k, Body one, Report found, Body& all, Report& report);

}  // namespace fascicle::build
