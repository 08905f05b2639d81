#include "host/scene/scene_writer.h"

#include <algorithm>
#include <sstream>
#include <string_view>

#include "host/scene/scene_check.h"
#include "host/scene/scene_table.h"

namespace fascicle::scene {
namespace {

// User-chosen names can contain anything; TOML requires quotes around some of them.
void write_name(std::ostream& out, std::string_view name) {
  if (is_valid_name(name))
    out << name;
  else
    out << toml::toml_formatter{toml::value<std::string>(std::string(name)), toml::format_flags::none};
}

// Writes tables inside values inline, in the order of their keys, and numbers as the shortest text that
// parses to the same value.
void write_value(std::ostream& out, const toml::node& node) {
  if (const auto* table = node.as_table()) {
    const char* separator = "";
    out << "{ ";
    for (const auto& [name, value] : in_order(*table)) {
      out << separator;
      write_name(out, name->str());
      out << " = ";
      write_value(out, *value);
      separator = ", ";
    }
    out << " }";
  } else if (const auto* array = node.as_array()) {
    const char* separator = "";
    out << "[";
    for (const toml::node& value : *array) {
      out << separator;
      write_value(out, value);
      separator = ", ";
    }
    out << "]";
  } else if (const auto* number = node.as_floating_point()) {
    const std::string text = shortest(number->get());
    out << text << (text.find_first_of(".e") == std::string::npos ? ".0" : "");
  } else {
    node.visit([&](const auto& value) { out << toml::toml_formatter{value}; });
  }
}

void add_keys(const toml::table& table, const std::string& path,
              std::vector<std::pair<std::string, std::string>>& keys) {
  for (const auto& [name, node] : in_order(table)) {
    std::ostringstream key, value;
    key << path;
    write_name(key, name->str());
    const toml::table* inner = node->as_table();
    if (inner != nullptr && !inner->empty()) {
      add_keys(*inner, key.str() + '.', keys);
      continue;
    }
    write_value(value, *node);
    keys.emplace_back(key.str(), value.str());
  }
}

bool is_header(const Key& key) {
  return key.type == KeyType::table || key.type == KeyType::named_tables;
}

void write_table(std::ostream& out, const toml::table& table, const Table& keys, const std::string& path) {
  const auto entries = in_order(table);
  for (const auto& [name, node] : entries) {
    if (is_header(*find_key(keys, name->str()))) continue;
    out << name->str() << " = ";
    write_value(out, *node);
    out << '\n';
  }
  for (const auto& [name, node] : entries) {
    const Key& key = *find_key(keys, name->str());
    if (!is_header(key)) continue;
    const std::string inner = join_path(path, name->str());
    if (!holds_named_tables(key, *node->as_table())) {
      out << "\n[" << inner << "]\n";
      write_table(out, *node->as_table(), *key.table, inner);
      continue;
    }
    for (const auto& [chosen, chosen_node] : in_order(*node->as_table())) {
      const std::string innermost = join_path(inner, chosen->str());
      out << "\n[" << innermost << "]\n";
      write_table(out, *chosen_node->as_table(), key.named != nullptr ? *key.named : *key.table, innermost);
    }
  }
}

constexpr std::size_t comment_width = 100;

// Word-wrapped text in lines that begin with "# ".
void write_comment(std::ostream& out, const std::string& text) {
  std::istringstream words(text);
  std::size_t column = 0;
  for (std::string word; words >> word;) {
    if (column > 0 && column + 1 + word.size() > comment_width) {
      out << '\n';
      column = 0;
    }
    out << (column == 0 ? "# " : " ") << word;
    column += (column == 0 ? 2 : 1) + word.size();
  }
  out << '\n';
}

// A default as TOML, which for these types looks like JSON.
std::string fallback_text(const nlohmann::ordered_json& fallback) {
  if (!fallback.is_array()) return fallback.dump();
  std::string text;
  for (const auto& value : fallback) text += (text.empty() ? "[" : ", ") + value.dump();
  return text + "]";
}

// The rival key that the table has in place of this one; null if it has none.
const std::string* taken_by(const Table& keys, const toml::table& table, const Key& key) {
  for (const auto* groups : {&keys.choices, &keys.alternatives})
    for (const auto& group : *groups) {
      if (std::find(group.begin(), group.end(), key.name) == group.end()) continue;
      for (const std::string& other : group)
        if (other != key.name && table.contains(other)) return &other;
    }
  return nullptr;
}

// The keys of one table that are not tables: those that are set, and the others as comments.
void write_documented_values(std::ostream& out, const toml::table& table, const Table& keys,
                             std::span<const char* const> left_out) {
  for (const Key& key : keys.keys) {
    if (is_header(key) || std::find(left_out.begin(), left_out.end(), key.name) != left_out.end()) continue;
    if (const toml::node* node = table.get(key.name)) {
      write_comment(out, key.doc);
      out << key.name << " = ";
      write_value(out, *node);
      out << '\n';
    } else if (const std::string* other = taken_by(keys, table, key)) {
      write_comment(out, "In place of " + *other + ": " + key.name + ". " + key.doc);
    } else if (key.fallback.is_null()) {
      write_comment(out, key.name + ": " + key.doc);
    } else {
      write_comment(out, key.doc);
      out << "#" << key.name << " = " << fallback_text(key.fallback) << '\n';
    }
  }
}

// A header and its contents. For tables of named tables that the scene does not have, only names the keys.
void write_documented_key(std::ostream& out, const toml::table& root, const Table& keys, const Key& key,
                          std::span<const char* const> left_out) {
  const toml::node* node = root.get(key.name);
  if (std::find(left_out.begin(), left_out.end(), key.name) != left_out.end()) return;
  if (node == nullptr && taken_by(keys, root, key) != nullptr) return;
  out << '\n';
  if (node != nullptr && holds_named_tables(key, *node->as_table())) {
    const Table& one = key.named != nullptr ? *key.named : *key.table;
    write_comment(out, one.doc);
    for (const auto& [name, inner] : in_order(*node->as_table())) {
      out << "[" << join_path(key.name, name->str()) << "]\n";
      write_documented_values(out, *inner->as_table(), one, left_out);
      out << '\n';
    }
  } else if (key.type == KeyType::named_tables) {
    std::string names;
    for (const std::string& name : key_names(*key.table)) names += (names.empty() ? "" : ", ") + name;
    write_comment(out, "[" + key.name + ".NAME] " + key.table->doc + " Keys: " + names + ".");
  } else {
    write_comment(out, key.table->doc);
    out << "[" << key.name << "]\n";
    static const toml::table empty;
    write_documented_values(out, node != nullptr ? *node->as_table() : empty, *key.table, left_out);
  }
}

}  // namespace

std::string write_scene(const toml::table& root) {
  std::ostringstream out;
  write_table(out, root, scene_table(), "");
  const std::string text = out.str();
  return text.starts_with('\n') ? text.substr(1) : text;
}

std::vector<std::pair<std::string, std::string>> keys_and_values(const toml::table& root) {
  std::vector<std::pair<std::string, std::string>> keys;
  add_keys(root, "", keys);
  return keys;
}

std::string write_documented_scene(const toml::table& root, std::span<const char* const> left_out) {
  std::ostringstream out;
  const Table& keys = scene_table();
  for (const Key& key : keys.keys) write_documented_key(out, root, keys, key, left_out);
  return out.str();
}

}  // namespace fascicle::scene
