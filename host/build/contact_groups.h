// Which flesh the scene excludes from contact: contact.ignore, contact.attribute and layers.NAME.contact;
// and, if contact.self is false, each character with itself.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/build/build.h"
#include "host/build/measures.h"
#include "host/scene/scene.h"

namespace fascicle::build {

struct ContactGroups {
  std::vector<char> meets_nothing;    // one flag per vertex; or empty: none
  std::vector<std::uint32_t> groups;  // per vertex: its groups, one bit each; or empty: none
  // For each group, the groups that it does not meet.
  std::array<std::uint32_t, scene::most_ignored_names> ignored{};
  // contact.self is false, and each of several characters is a group that does not meet itself.
  bool meets_others_only = false;
};

// `layer` is each vertex's layer. Throws scene::SceneError for a name that does not exist, and warns of one
// without flesh.
ContactGroups contact_groups(const scene::Scene& scene, const std::vector<std::uint32_t>& layer,
                             Measures& measures, Report& report);

}  // namespace fascicle::build
