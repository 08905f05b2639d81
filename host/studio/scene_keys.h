// The scene's keys as the page shows them, and wishes that change several at once.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "host/scene/scene_edit.h"
#include "host/scene/scene_json.h"
#include "host/studio/running_body.h"

namespace fascicle::studio {

using scene::Json;

// Whether a change of the key asks for a new body: what is filled with tetrahedra, and from which bones it is
// measured.
bool needs_new_body(std::string_view path);

// The key that names what is painted on a scene's only character.
inline constexpr std::string_view paint_path = "character.paint";
// What its file's name ends in.
inline constexpr const char* paint_suffix = ".paint.json";
// The files that the scene's characters name for what is painted on them, by their keys.
std::map<std::string, std::string> paint_files(const std::vector<scene::EditedTable>& tables);

// "groups" of the message `keys`.
Json keys_json(const std::vector<scene::EditedTable>& tables);

// A wish, as changes of keys from what is in force.
struct Preset {
  std::string name, title, doc;
  std::vector<scene::KeyChange> changes;
  std::string why_not;  // where it does not apply; empty: it does
};
std::vector<Preset> presets_of(const RunningBody& body, const std::vector<scene::EditedTable>& tables);
// "list" of the message `presets`.
Json presets_json(const std::vector<Preset>& presets);

}  // namespace fascicle::studio
