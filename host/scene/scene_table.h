// The scene file's keys: one table that the checker (scene_check.h), --set (overrides.h), the JSON Schema and
// docs/scene.md (scene_schema.cpp) and the documented scene (scene_writer.h) are made from, so that they
// cannot disagree. A key has one row, beside the others of its table, in scene_keys_*.cpp.
#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace fascicle::scene {

enum class KeyType {
  number,
  integer,
  text,
  boolean,
  vector,          // three numbers
  integer_vector,  // three whole numbers
  numbers,         // any count of numbers
  texts,           // an array of at least one text
  name_lists,      // an array of at least one array of one or two texts
  points,          // an array of at least two vectors
  curve,           // an array of at least one pair [x, value], x ascending
  named_numbers,   // a table of at least one number, under names the user chooses; any text will do
  table,
  tables,        // one table, or an array of at least one
  named_tables,  // a table of tables, whose names the user chooses
};

// Bounds of a number, or of each entry of a vector. Infinite and undefined numbers are refused everywhere.
struct Range {
  double minimum = -std::numeric_limits<double>::infinity();
  double maximum = std::numeric_limits<double>::infinity();
  bool minimum_excluded = false;
};

struct Table;

struct Key {
  std::string name;
  KeyType type = KeyType::number;
  std::string doc;  // one line, ends in a full stop
  Range range = {};
  nlohmann::ordered_json fallback =
      {};  // what holds where the key is absent; null where that is nothing or depends
  std::vector<std::string> allowed =
      {};  // text: all values there are; empty: any. integer: words beside numbers
  bool required = false;
  const Table* table = nullptr;  // of the types that are tables
  // table: where it holds nothing but tables, it is a table of tables like this, whose names the user
  // chooses.
  const Table* named = nullptr;
};

struct Table {
  std::string name;  // in the schema's $defs
  std::string doc;
  std::vector<Key> keys = {};
  std::vector<std::vector<std::string>> choices =
      {};  // of each group exactly one key is given; --set of one drops the others
  std::vector<std::vector<std::string>> alternatives = {};  // the same, but none need be given
};

// The root of the scene file.
const Table& scene_table();

// Null if there is none of that name.
const Key* find_key(const Table& table, std::string_view name);
std::vector<std::string> key_names(const Table& table);

// Names that users choose: what TOML takes as a bare key, so that they can stand in paths of --set and in
// column headers.
inline constexpr const char* name_pattern = "^[A-Za-z0-9_-]+$";
inline constexpr std::size_t longest_name = 64;
inline constexpr std::size_t most_named = 256;  // shader::tag_layer_mask leaves a byte for the layer
bool is_valid_name(std::string_view name);

}  // namespace fascicle::scene
