// A scene file's text as an editor sees it: its keys with what holds of each, and changes that leave the rest
// of the text, comments and all, as it stands.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/scene/scene_json.h"
#include "host/scene/scene_table.h"

namespace fascicle::scene {

// A key of a table that the scene has, or might have.
struct EditedKey {
  std::string path;          // as --set takes it: "layers.fat.alpha"
  const Key* key = nullptr;  // of the table of keys, which is there for good
  Json value;                // what the text states, else what holds without; null where that is nothing
  bool is_stated = false;    // the text has it
  std::vector<std::string> rivals;  // keys that go when this one is set: "frequency"
};
// A table with the keys that are no tables themselves.
struct EditedTable {
  std::string path;
  const Table* table = nullptr;
  std::vector<EditedKey> keys;
};

// Every table of the text and those it may have beside them, in the order of the table of keys; of tables
// whose names the user chooses those that are there. `text` has been read by load_scene or parse_scene.
std::vector<EditedTable> edited_tables(const std::string& text, const std::string& source);

struct KeyChange {
  std::string path;
  std::optional<Json> value;  // nothing: the key is taken out
};
struct ChangedText {
  std::string text;
  bool keeps_comments = true;  // false: it had to be written anew, and has none
};

// The text with the changes, in order; keys that cannot stand beside a new one go. The result passes
// check_scene. Throws SceneError that says which key is wrong and why, and leaves nothing changed.
ChangedText change_text(std::string_view text, const std::string& source, std::span<const KeyChange> changes);

}  // namespace fascicle::scene
