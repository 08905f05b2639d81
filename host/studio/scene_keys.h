// The scene's keys as the page shows them, and presets that change several keys.
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

// Whether changing the key requires a new body: it affects what is filled with tetrahedra, or the bones from
// which it is measured.
bool needs_new_body(std::string_view path);

// The key that names the paint file of a scene's only character.
inline constexpr std::string_view paint_path = "character.paint";
// The suffix of paint files.
inline constexpr const char* paint_suffix = ".paint.json";
// The paint files of the scene's characters, by their keys.
std::map<std::string, std::string> paint_files(const std::vector<scene::EditedTable>& tables);

// "groups" of the message `keys`.
Json keys_json(const std::vector<scene::EditedTable>& tables);

// A preset, as changes to the current keys.
struct Preset {
  std::string name, title, doc;
  std::vector<scene::KeyChange> changes;
  std::string why_not;  // why it does not apply; empty: it does
};
std::vector<Preset> presets_of(const RunningBody& body, const std::vector<scene::EditedTable>& tables);
// "list" of the message `presets`.
Json presets_json(const std::vector<Preset>& presets);

}  // namespace fascicle::studio
