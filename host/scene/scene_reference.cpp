// Writes the scene file's keys as Markdown from the table of keys: docs/scene.md.
#include <cmath>
#include <set>
#include <sstream>
#include <utility>

#include "host/scene/scene.h"
#include "host/scene/scene_check.h"
#include "host/scene/scene_table.h"

namespace fascicle::scene {
namespace {

constexpr std::size_t width = 116;

const char* type_words(const Key& key) {
  switch (key.type) {
    case KeyType::number:
      return "number";
    case KeyType::integer:
      return "whole number";
    case KeyType::text:
      return "text";
    case KeyType::boolean:
      return "true or false";
    case KeyType::vector:
      return "three numbers";
    case KeyType::integer_vector:
      return "three whole numbers";
    case KeyType::numbers:
      return "list of numbers";
    case KeyType::texts:
      return "list of texts";
    case KeyType::name_lists:
      return "list of lists of one or two texts";
    case KeyType::points:
      return "list of points, three numbers each";
    case KeyType::curve:
      return "list of pairs `[x, value]`, x ascending";
    case KeyType::named_numbers:
      return "table of numbers by name";
    case KeyType::table:
      return "table";
    case KeyType::tables:
      return "table, or list of tables";
    case KeyType::named_tables:
      return "tables by name";
  }
  return "";
}

std::string range_words(const Range& range) {
  const bool low = std::isfinite(range.minimum), high = std::isfinite(range.maximum);
  const std::string from = range.minimum_excluded ? "above " : "at least ";
  if (low && high && !range.minimum_excluded)
    return shortest(range.minimum) + " to " + shortest(range.maximum);
  std::string text;
  if (low) text = from + shortest(range.minimum);
  if (high) text += (low ? ", at most " : "at most ") + shortest(range.maximum);
  return text;
}

std::string words_of(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "`\"" : ", `\"") + word + "\"`";
  return text;
}

// A list item; continuation lines are indented.
void write_item(std::ostream& out, const std::string& text) {
  std::istringstream words(text);
  std::size_t column = 1;
  out << '-';
  for (std::string word; words >> word;) {
    if (column + 1 + word.size() > width) {
      out << "\n ";
      column = 1;
    }
    out << ' ' << word;
    column += 1 + word.size();
  }
  out << '\n';
}

void write_paragraph(std::ostream& out, const std::string& text) {
  std::istringstream words(text);
  std::size_t column = 0;
  for (std::string word; words >> word;) {
    if (column > 0 && column + 1 + word.size() > width) {
      out << '\n';
      column = 0;
    }
    out << (column > 0 ? " " : "") << word;
    column += (column > 0 ? 1 : 0) + word.size();
  }
  out << "\n\n";
}

void write_key(std::ostream& out, const Key& key) {
  std::string text = "`" + key.name + "`: " + type_words(key);
  if (const std::string range = range_words(key.range); !range.empty()) text += ", " + range;
  if (!key.allowed.empty()) text += (key.type == KeyType::integer ? ", or " : ": ") + words_of(key.allowed);
  text += key.required ? "; required. " : ". ";
  text += key.doc;
  if (!key.fallback.is_null()) text += " Default: `" + key.fallback.dump() + "`.";
  if (key.table != nullptr) text += " Keys: [" + key.table->name + "](#" + key.table->name + ").";
  write_item(out, text);
}

void write_groups(std::ostream& out, const Table& table) {
  const auto names = [](const std::vector<std::string>& group) {
    std::string text;
    for (const std::string& name : group) text += (text.empty() ? "`" : ", `") + name + "`";
    return text;
  };
  for (const auto& group : table.choices) write_paragraph(out, "Exactly one of " + names(group) + ".");
  for (const auto& group : table.alternatives) write_paragraph(out, "At most one of " + names(group) + ".");
}

void write_table(std::ostream& out, const Table& table, std::set<const Table*>& done) {
  if (!done.insert(&table).second) return;
  out << "## " << table.name << "\n\n";
  write_paragraph(out, table.doc);
  write_groups(out, table);
  for (const Key& key : table.keys) write_key(out, key);
  out << '\n';
  for (const Key& key : table.keys)
    for (const Table* inner : {key.table, key.named})
      if (inner != nullptr) write_table(out, *inner, done);
}

}  // namespace

std::string scene_reference() {
  std::ostringstream out;
  out << "# The scene file: every key\n\n";
  write_paragraph(
      out,
      "`fascicle schema --markdown` prints this page, from the table that scene files are checked "
      "against; `./do scene-reference` writes it. Metres, kilograms, seconds, Y up. `--set "
      "layers.fat.beta=0.5` changes a key without a file. It adds a named table only as a whole: `--set "
      "'collider.floor={shape=\"plane\"}'`.");
  const Table& root = scene_table();
  write_paragraph(out, "A file has these tables.");
  write_groups(out, root);
  for (const Key& key : root.keys) {
    const std::string header = key.type == KeyType::named_tables ? key.name + ".NAME" : key.name;
    write_item(out, "`[" + header + "]`: " + key.doc + " Keys: [" + key.table->name + "](#" +
                        key.table->name + ").");
    if (key.named != nullptr)
      write_item(out, "`[" + key.name + ".NAME]`: " + key.named->doc + " Keys: [" + key.named->name + "](#" +
                          key.named->name + ").");
  }
  out << '\n';
  std::set<const Table*> done;
  for (const Key& key : root.keys)
    for (const Table* inner : {key.table, key.named})
      if (inner != nullptr) write_table(out, *inner, done);
  std::string text = out.str();
  while (text.ends_with("\n\n")) text.pop_back();
  return text;
}

}  // namespace fascicle::scene
