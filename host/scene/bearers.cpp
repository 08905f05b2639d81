#include "host/scene/bearers.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>

#include "host/base/nearest_name.h"
#include "host/rig/rig_math.h"
#include "host/scene/scene_values.h"

namespace fascicle::scene {

namespace {

struct Bearer {
  std::size_t character = 0;
  std::uint32_t joint = 0;       // within that character in the scene; 0 is above all joints of its file
  Eigen::Matrix4d inverse_bind;  // from that character's own bind pose to the joint's space
};

std::optional<Bearer> bearer_called(const std::vector<PlacedCharacter>& characters, const std::string& name) {
  for (std::size_t k = 0; k < characters.size(); ++k) {
    const rig::Character& own = characters[k].own;
    if (name == characters[k].settings.name) return Bearer{k, 0, rig::affine_inverse(own.root)};
    for (std::size_t j = 0; j < own.skeleton.size(); ++j)
      if (own.skeleton[j].name == name)
        return Bearer{k, static_cast<std::uint32_t>(j + 1), own.skeleton[j].inverse_bind};
  }
  return std::nullopt;
}

[[noreturn]] void refuse(const toml::table& root, const std::string& character, const std::string& what) {
  const toml::node& joint = *root["character"][character]["joint"].node();
  fail(joint.source(), join_path(join_path("character", character), "joint"), what);
}

// For each character, the one whose joint carries it.
std::vector<std::optional<std::size_t>> bearers_of(const toml::table& root,
                                                   const std::vector<PlacedCharacter>& characters) {
  std::vector<std::optional<std::size_t>> bearers(characters.size());
  for (std::size_t k = 0; k < characters.size(); ++k) {
    const CharacterSettings& settings = characters[k].settings;
    if (settings.joint.empty()) continue;
    const std::optional<Bearer> found = bearer_called(characters, settings.joint);
    if (!found) {
      std::vector<std::string> names;
      for (std::size_t other = 0; other < characters.size(); ++other) {
        if (other == k) continue;
        names.push_back(characters[other].settings.name);
        for (const rig::Joint& joint : characters[other].own.skeleton) names.push_back(joint.name);
      }
      const std::string hint = base::nearest_name_hint(settings.joint, names);
      refuse(root, settings.name,
             "no other character has a joint \"" + one_line(settings.joint) + "\"" +
                 (hint.empty() ? "; `fascicle inspect` lists them" : hint));
    }
    if (found->character == k)
      refuse(root, settings.name,
             "\"" + one_line(settings.joint) + "\" is one of its own joints; name one of another character");
    bearers[k] = found->character;
  }
  return bearers;
}

}  // namespace

void put_bearers_first(const toml::table& root, Scene& scene) {
  const std::vector<std::optional<std::size_t>> bearers = bearers_of(root, scene.characters);
  std::vector<char> is_placed(bearers.size(), 0);
  std::vector<PlacedCharacter> ordered;
  const auto is_next = [&](std::size_t k) {
    return is_placed[k] == 0 && (!bearers[k] || is_placed[*bearers[k]] != 0);
  };
  while (ordered.size() < bearers.size()) {
    std::size_t k = 0;
    while (k < bearers.size() && !is_next(k)) ++k;
    if (k == bearers.size()) {
      k = static_cast<std::size_t>(std::find(is_placed.begin(), is_placed.end(), 0) - is_placed.begin());
      refuse(
          root, scene.characters[k].settings.name,
          "the characters that it is attached to are attached to each other in a cycle; remove one `joint`");
    }
    is_placed[k] = 1;
    ordered.push_back(std::move(scene.characters[k]));
  }
  scene.characters = std::move(ordered);
}

void place(const std::vector<PlacedCharacter>& characters, const Eigen::Matrix4d& held,
           PlacedCharacter& character) {
  character.place = held;
  const std::optional<Bearer> bearer =
      character.settings.joint.empty() ? std::nullopt : bearer_called(characters, character.settings.joint);
  if (!bearer) return;
  character.bearer = characters[bearer->character].first_joint + bearer->joint;
  character.place.topRightCorner<3, 1>() += rig::affine_inverse(bearer->inverse_bind).topRightCorner<3, 1>();
  character.place = (bearer->inverse_bind * character.place).eval();
}

}  // namespace fascicle::scene
