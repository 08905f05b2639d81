#include "host/cli/rigid_rows.h"

#include <map>
#include <tuple>

#include "host/cli/text.h"

namespace fascicle::cli {

RigidRows rigid_rows(const std::vector<build::RigidReport>& parts, std::size_t most) {
  struct Group {
    const build::RigidReport* part = nullptr;
    std::size_t count = 0;
  };
  std::vector<Group> groups;
  std::map<std::tuple<std::string, std::string, std::string, std::uint32_t>, std::size_t> places;
  for (const build::RigidReport& part : parts) {
    const auto [place, is_new] =
        places.try_emplace({part.name, part.joint, part.reason, part.vertices}, groups.size());
    if (is_new) groups.push_back({&part, 0});
    ++groups[place->second].count;
  }
  RigidRows shown;
  for (const auto& [part, count] : groups) {
    if (shown.rows.size() == most) {
      shown.left_out += count;
      continue;
    }
    const std::string vertices = counted_text(part->vertices, "vertex", "vertices") + "; " + part->reason;
    shown.rows.emplace_back(part->name, count == 1 ? "follows " + part->joint + ", " + vertices
                                                   : count_text(count) + " parts follow " + part->joint +
                                                         ", each of " + vertices);
  }
  return shown;
}

}  // namespace fascicle::cli
