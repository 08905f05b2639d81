#include "host/made/made_character.h"

#include "host/base/errors.h"
#include "host/made/made_arm.h"
#include "host/made/made_bear.h"

namespace fascicle::made {
namespace {

struct Maker {
  const char* name;
  rig::Character (*make)();
};

constexpr double bent_by = 46.0;  // degrees
constexpr Maker makers[] = {{"bear", make_bear},
                            {"arm", [] { return make_arm(0.0); }},
                            {"arm-bent", [] { return make_arm(bent_by); }}};

}  // namespace

std::vector<std::string> made_character_names() {
  std::vector<std::string> names;
  for (const Maker& maker : makers) names.emplace_back(maker.name);
  return names;
}

rig::Character make_character(const std::string& name) {
  for (const Maker& maker : makers)
    if (maker.name == name) {
      rig::Character character = maker.make();
      const auto vertices = static_cast<std::uint32_t>(character.surface.vertices.size());
      const auto triangles = static_cast<std::uint32_t>(character.surface.triangles.size());
      character.parts.push_back({name, "", 0, 0, vertices, 0, triangles});
      return character;
    }
  throw base::SceneError("there is no character `" + name + "` made in code");
}

}  // namespace fascicle::made
