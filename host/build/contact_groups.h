// Which flesh the scene keeps from meeting: contact.ignore, contact.attribute and layers.NAME.contact; and
// where contact.self is false, each character's own.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/build/build.h"
#include "host/build/measures.h"
#include "host/scene/scene.h"

namespace fascicle::build {

struct ContactGroups {
  std::vector<char> meets_nothing;    // a flag a vertex, or empty: none
  std::vector<std::uint32_t> groups;  // a vertex: those that it is of, a bit each; or empty: none
  // Of each group those that it does not meet.
  std::array<std::uint32_t, scene::most_ignored_names> ignored{};
  // contact.self is false, and each of several characters is a group that does not meet itself.
  bool meets_others_only = false;
};

// `layer` is each vertex's. Throws scene::SceneError for a name that nothing has, and warns of one that has
// no flesh.
ContactGroups contact_groups(const scene::Scene& scene, const std::vector<std::uint32_t>& layer,
                             Measures& measures, Report& report);

}  // namespace fascicle::build
