// The names that a scene can use for parts of a character's surface.
#pragma once

#include <set>
#include <string>
#include <variant>

#include "host/rig/character.h"
#include "host/scene/scene.h"

namespace fascicle::cli {

struct PartNames {
  std::set<std::string> objects, materials;
};

// Empty without a character.
inline PartNames names_of_parts(const scene::Scene& scene) {
  PartNames names;
  const auto* character = std::get_if<rig::Character>(&scene.geometry);
  if (character == nullptr) return names;
  for (const rig::SurfacePart& part : character->parts) {
    names.objects.insert(part.object);
    if (!part.material.empty()) names.materials.insert(part.material);
  }
  return names;
}

}  // namespace fascicle::cli
