// The scene file's keys. The checker (scene_check.h), --set (overrides.h), the JSON Schema and docs/scene.md
// (scene_schema.cpp) and the documented scene (scene_writer.h) all use this one table, so that they cannot
// disagree. Each key has one row, with the others of its table, in scene_keys_*.cpp.
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
  named_numbers,   // a table of at least one number under user-chosen names, which may be any text
  table,
  tables,        // one table, or an array of at least one
  named_tables,  // a table of tables with user-chosen names
};

// Bounds of a number, or of each entry of a vector. Infinity and NaN are always rejected.
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
  nlohmann::ordered_json fallback = {};  // the default; null if there is none or it depends
  std::vector<std::string> allowed =
      {};  // text: all allowed values; empty: any. integer: words allowed besides numbers
  bool required = false;
  const Table* table = nullptr;  // for types that are tables
  // For `table`: if it contains nothing but tables, each of them is a table of this kind, with a user-chosen
  // name.
  const Table* named = nullptr;
};

struct Table {
  std::string name;  // in the schema's $defs
  std::string doc;
  std::vector<Key> keys = {};
  std::vector<std::vector<std::string>> choices =
      {};  // exactly one key of each group is required; --set of one removes the others
  std::vector<std::vector<std::string>> alternatives = {};  // the same, but may be absent
};

// The root of the scene file.
const Table& scene_table();

// Null if there is no such key.
const Key* find_key(const Table& table, std::string_view name);
std::vector<std::string> key_names(const Table& table);

// User-chosen names are bare keys of TOML, so that they can appear in paths of --set and in column headers.
inline constexpr const char* name_pattern = "^[A-Za-z0-9_-]+$";
inline constexpr std::size_t longest_name = 64;
inline constexpr std::size_t most_named = 256;  // shader::tag_layer_mask leaves a byte for the layer
bool is_valid_name(std::string_view name);

}  // namespace fascicle::scene
