// A scene file's text as an editor sees it: its keys with their values, and changes that keep the rest of the
// text as it is, including comments.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/scene/scene_json.h"
#include "host/scene/scene_table.h"

namespace fascicle::scene {

// A key of a table that the scene has or could have.
struct EditedKey {
  std::string path;                 // as --set takes it: "layers.fat.alpha"
  const Key* key = nullptr;         // in the table of keys, which is never destroyed
  Json value;                       // stated in the text, or else the default; null if there is none
  bool is_stated = false;           // the text states it
  std::vector<std::string> rivals;  // keys that are removed when this one is set: "frequency"
};
// A table with those of its keys that are not tables.
struct EditedTable {
  std::string path;
  const Table* table = nullptr;
  std::vector<EditedKey> keys;
};

// Every table of the text and those it may add, in the order of the table of keys; of tables with user-chosen
// names, only those that exist. Throws SceneError if `text` is not TOML or fails check_scene.
std::vector<EditedTable> edited_tables(const std::string& text, const std::string& source);

struct KeyChange {
  std::string path;
  std::optional<Json> value;  // nullopt: removes the key
};
struct ChangedText {
  std::string text;
  bool keeps_comments = true;  // false: the text had to be rewritten, and its comments are lost
};

// Applies the changes in order; keys that exclude a new one are removed. The result passes check_scene.
// Throws SceneError that says which key is wrong and why; `text` is then unchanged.
ChangedText change_text(std::string_view text, const std::string& source, std::span<const KeyChange> changes);

}  // namespace fascicle::scene
