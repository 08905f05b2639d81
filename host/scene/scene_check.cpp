#include "host/scene/scene_check.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <tuple>

#include "host/base/nearest_name.h"
#include "host/base/text.h"
#include "host/scene/scene.h"

namespace fascicle::scene {
namespace {

std::string shortened_in_quotes(std::string_view text) {
  constexpr std::size_t longest_shown = 80;
  const bool cut = text.size() > longest_shown;
  return '"' + std::string(text.substr(0, longest_shown)) + (cut ? "...\"" : "\"");
}

std::string list(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

const char* type_given(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return "an array";
    case toml::node_type::string:
      return "text";
    case toml::node_type::integer:
      return "a whole number";
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "true or false";
    default:
      return "a date or time";
  }
}

const char* type_wanted(KeyType type) {
  switch (type) {
    case KeyType::number:
      return "a number";
    case KeyType::integer:
      return "a whole number";
    case KeyType::text:
      return "text in quotes";
    case KeyType::boolean:
      return "true or false";
    case KeyType::vector:
      return "an array of three numbers";
    case KeyType::integer_vector:
      return "an array of three whole numbers";
    case KeyType::numbers:
      return "an array of numbers";
    case KeyType::texts:
      return "an array of texts in quotes";
    case KeyType::name_lists:
      return "an array of arrays of one or two texts in quotes";
    case KeyType::points:
      return "an array of two or more points, each of three numbers";
    case KeyType::curve:
      return "an array of pairs of numbers";
    case KeyType::named_numbers:
      return "a table of numbers";
    case KeyType::table:
      return "a table";
    case KeyType::tables:
      return "a table, or an array of tables";
    case KeyType::named_tables:
      return "a table of tables";
  }
  return "";
}

[[noreturn]] void fail_type(const toml::node& node, const Key& key, const std::string& path) {
  fail(node.source(), path, std::string("takes ") + type_wanted(key.type) + ", not " + type_given(node));
}

void check_number(const toml::node& node, const Key& key, const std::string& path) {
  const bool whole = key.type == KeyType::integer || key.type == KeyType::integer_vector;
  double value = 0.0;
  if (const auto* integer = node.as_integer()) {
    value = static_cast<double>(integer->get());
  } else if (const auto* floating = node.as_floating_point(); floating != nullptr && !whole) {
    value = floating->get();
  } else {
    fail_type(node, key, path);
  }
  if (!std::isfinite(value)) fail(node.source(), path, "is not a finite number");
  const Range& range = key.range;
  if (range.minimum_excluded ? !(value > range.minimum) : !(value >= range.minimum)) {
    fail(node.source(), path,
         "is " + shortest(value) + "; must be " + (range.minimum_excluded ? "above " : "at least ") +
             shortest(range.minimum));
  }
  if (value > range.maximum) {
    fail(node.source(), path, "is " + shortest(value) + "; must be at most " + shortest(range.maximum));
  }
}

void check_vector(const toml::node& node, const Key& key, const std::string& path) {
  const toml::array* array = node.as_array();
  if (array == nullptr) fail_type(node, key, path);
  if (array->size() != 3 && key.type != KeyType::numbers) {
    fail(node.source(), path,
         "has " + std::to_string(array->size()) + " entries; takes " + type_wanted(key.type));
  }
  for (std::size_t i = 0; i < array->size(); ++i)
    check_number((*array)[i], key, path + "[" + std::to_string(i) + "]");
}

void check_text(const toml::node& node, const Key& key, const std::string& path) {
  const auto* text = node.as_string();
  if (text == nullptr) fail_type(node, key, path);
  const auto& allowed = key.allowed;
  if (allowed.empty() || std::find(allowed.begin(), allowed.end(), text->get()) != allowed.end()) return;
  fail(node.source(), path,
       shortened_in_quotes(text->get()) + " is not one of " + list(allowed) +
           base::nearest_name_hint(text->get(), allowed));
}

void check_texts(const toml::node& node, const Key& key, const std::string& path) {
  const toml::array* array = node.as_array();
  if (array == nullptr) fail_type(node, key, path);
  if (array->empty()) fail(node.source(), path, "is empty; leave it out, or name something");
  for (std::size_t i = 0; i < array->size(); ++i)
    if (!(*array)[i].is_string()) fail_type((*array)[i], key, path + "[" + std::to_string(i) + "]");
}

void check_name_lists(const toml::node& node, const Key& key, const std::string& path) {
  const toml::array* array = node.as_array();
  if (array == nullptr) fail_type(node, key, path);
  if (array->empty()) fail(node.source(), path, "is empty; leave it out, or name something");
  for (std::size_t i = 0; i < array->size(); ++i) {
    const std::string inner = path + "[" + std::to_string(i) + "]";
    const toml::array* names = (*array)[i].as_array();
    if (names == nullptr)
      fail((*array)[i].source(), inner,
           std::string("takes an array of one or two names, [\"a\", \"b\"], not ") + type_given((*array)[i]));
    if (names->empty() || names->size() > 2)
      fail(names->source(), inner,
           "has " + std::to_string(names->size()) +
               " names; give two that have no contact with each other, or one that has none at all");
    for (std::size_t k = 0; k < names->size(); ++k)
      if (!(*names)[k].is_string())
        fail((*names)[k].source(), inner + "[" + std::to_string(k) + "]",
             std::string("takes text in quotes, not ") + type_given((*names)[k]));
  }
}

void check_points(const toml::node& node, const Key& key, const std::string& path) {
  const toml::array* array = node.as_array();
  if (array == nullptr) fail_type(node, key, path);
  if (array->size() < 2)
    fail(node.source(), path,
         "has " + std::to_string(array->size()) + " entries; takes " + type_wanted(key.type));
  for (std::size_t i = 0; i < array->size(); ++i)
    check_vector((*array)[i], key, path + "[" + std::to_string(i) + "]");
}

void check_curve(const toml::node& node, const Key& key, const std::string& path) {
  const toml::array* array = node.as_array();
  if (array == nullptr) fail_type(node, key, path);
  if (array->empty()) fail(node.source(), path, "is empty; leave it out, or give a pair");
  double before = 0.0;
  for (std::size_t i = 0; i < array->size(); ++i) {
    const std::string inner = path + "[" + std::to_string(i) + "]";
    const toml::array* pair = (*array)[i].as_array();
    if (pair == nullptr) fail_type((*array)[i], key, inner);
    if (pair->size() != 2)
      fail(pair->source(), inner,
           "has " + std::to_string(pair->size()) + " entries; takes a pair, [x, value]");
    for (std::size_t k = 0; k < 2; ++k) check_number((*pair)[k], key, inner + "[" + std::to_string(k) + "]");
    const double x = *(*pair)[0].value<double>();
    if (i > 0 && !(x > before))
      fail(pair->source(), inner, "does not come after the pair before it; sort them");
    before = x;
  }
}

void check_named_numbers(const toml::node& node, const Key& key, const std::string& path) {
  const toml::table* table = node.as_table();
  if (table == nullptr) fail_type(node, key, path);
  if (table->empty()) fail(node.source(), path, "is empty; leave it out, or name something");
  for (const auto& [name, value] : in_order(*table)) {
    const std::string inner = join_path(path, name->str());
    if (!value->is_number())
      fail(value->source(), inner, std::string("takes a number, not ") + type_given(*value));
    check_number(*value, key, inner);
  }
}

void check_table(const toml::table& table, const Table& keys, const std::string& path);

void check_tables(const toml::node& node, const Key& key, const std::string& path) {
  if (const auto* table = node.as_table()) return check_table(*table, *key.table, path);
  const toml::array* array = node.as_array();
  if (array == nullptr) fail_type(node, key, path);
  if (array->empty()) fail(node.source(), path, "is empty; give at least one table");
  for (std::size_t i = 0; i < array->size(); ++i) {
    const auto* table = (*array)[i].as_table();
    if (table == nullptr) fail_type((*array)[i], key, path);
    check_table(*table, *key.table, path + "[" + std::to_string(i) + "]");
  }
}

void check_named_tables(const toml::node& node, const Key& key, const std::string& path) {
  const auto* tables = node.as_table();
  if (tables == nullptr) fail_type(node, key, path);
  for (const auto& [name, value] : in_order(*tables)) {
    const std::string inner = join_path(path, name->str());
    if (!is_valid_name(name->str())) {
      fail(name->source(), inner,
           "is not a name; names have 1 to " + std::to_string(longest_name) + " letters, digits, _ and -");
    }
    const auto* table = value->as_table();
    if (table == nullptr) {
      fail(value->source(), inner, std::string("takes a table, [") + inner + "], not " + type_given(*value));
    }
    check_table(*table, *key.table, inner);
  }
  if (tables->size() > most_named) {
    fail(node.source(), path,
         "has " + std::to_string(tables->size()) + " tables; at most " + std::to_string(most_named) +
             " are allowed");
  }
  if (key.required && tables->empty())
    fail(node.source(), path, "is empty; give at least one [" + path + ".NAME]");
}

// Allows either the keys of one table or tables by name, not both.
void check_table_or_named(const toml::table& table, const Key& key, const std::string& path) {
  if (holds_named_tables(key, table)) {
    Key by_name = key;
    by_name.table = key.named;
    return check_named_tables(table, by_name, path);
  }
  const toml::node* first = nullptr;
  for (const auto& [name, value] : in_order(table))
    if (value->is_table() && find_key(*key.table, name->str()) == nullptr) first = value;
  for (const auto& [name, value] : in_order(table))
    if (first != nullptr && !value->is_table())
      fail(name->source(), join_path(path, name->str()),
           "conflicts with the tables of single characters, [" + path +
               ".NAME]; move it into each of them, or remove their names");
  check_table(table, *key.table, path);
}

void check_node(const toml::node& node, const Key& key, const std::string& path) {
  switch (key.type) {
    case KeyType::number:
    case KeyType::integer:
      if (node.is_string() && !key.allowed.empty()) return check_text(node, key, path);
      return check_number(node, key, path);
    case KeyType::text:
      return check_text(node, key, path);
    case KeyType::boolean:
      if (!node.is_boolean()) fail_type(node, key, path);
      return;
    case KeyType::vector:
    case KeyType::integer_vector:
    case KeyType::numbers:
      return check_vector(node, key, path);
    case KeyType::texts:
      return check_texts(node, key, path);
    case KeyType::name_lists:
      return check_name_lists(node, key, path);
    case KeyType::points:
      return check_points(node, key, path);
    case KeyType::curve:
      return check_curve(node, key, path);
    case KeyType::named_numbers:
      return check_named_numbers(node, key, path);
    case KeyType::table:
      if (!node.is_table()) fail_type(node, key, path);
      if (key.named != nullptr) return check_table_or_named(*node.as_table(), key, path);
      return check_table(*node.as_table(), *key.table, path);
    case KeyType::tables:
      return check_tables(node, key, path);
    case KeyType::named_tables:
      return check_named_tables(node, key, path);
  }
}

void check_table(const toml::table& table, const Table& keys, const std::string& path) {
  const auto entries = in_order(table);
  // Check for unknown names first, or a mistyped table's keys would be reported as missing.
  for (const auto& [name, value] : entries) {
    if (find_key(keys, name->str()) == nullptr) {
      fail_unknown(name->source(), path, name->str(), key_names(keys));
    }
  }
  for (const auto& [name, value] : entries) {
    check_node(*value, *find_key(keys, name->str()), join_path(path, name->str()));
  }
  for (const Key& key : keys.keys) {
    if (key.required && !table.contains(key.name)) {
      fail(table.source(), join_path(path, key.name),
           std::string("is missing; takes ") + type_wanted(key.type));
    }
  }
  const auto first_of = [&](const std::vector<std::string>& choice) {
    const Entry* first = nullptr;
    for (const Entry& entry : entries) {
      if (std::find(choice.begin(), choice.end(), entry.first->str()) == choice.end()) continue;
      if (first != nullptr) {
        fail(entry.first->source(), join_path(path, entry.first->str()),
             "conflicts with " + std::string(first->first->str()) + "; give one of " + list(choice));
      }
      first = &entry;
    }
    return first;
  };
  for (const auto& choice : keys.choices) {
    const Entry* first = first_of(choice);
    if (first == nullptr) fail(table.source(), path.empty() ? "scene" : path, "lacks one of " + list(choice));
  }
  for (const auto& group : keys.alternatives) first_of(group);
}

}  // namespace

bool is_override(const toml::source_region& source) {
  return source.path && source.path->starts_with("--");
}

std::string location(const toml::source_region& source) {
  const std::string file = source.path ? *source.path : std::string{};
  if (is_override(source)) return file;
  return file + ":" + std::to_string(std::max<toml::source_index>(source.begin.line, 1));
}

std::string shortest(double value) {
  char text[32];
  const auto end = std::to_chars(std::begin(text), std::end(text), value).ptr;
  return {text, end};
}

std::string join_path(std::string_view path, std::string_view name) {
  return path.empty() ? std::string(name) : std::string(path) + "." + std::string(name);
}

std::string one_line(const std::string& text) {
  return base::shown_text(text);
}

void fail(const toml::source_region& source, std::string_view path, std::string_view message) {
  throw SceneError(one_line(location(source) + ": " + std::string(path) + ": " + std::string(message)));
}

void fail_unknown(const toml::source_region& source, std::string_view path, std::string_view name,
                  const std::vector<std::string>& names) {
  const std::string hint = base::nearest_name_hint(name, names);
  const std::string there_is = names.empty()  ? "; no name is known here"
                               : hint.empty() ? "; known here: " + list(names)
                                              : hint + " Known here: " + list(names);
  fail(source, join_path(path, name.substr(0, longest_name)), "unknown" + there_is);
}

bool holds_named_tables(const Key& key, const toml::table& table) {
  if (key.type == KeyType::named_tables) return true;
  if (key.named == nullptr || table.empty()) return false;
  return std::all_of(table.begin(), table.end(), [](const auto& entry) { return entry.second.is_table(); });
}

std::vector<Entry> in_order(const toml::table& table) {
  std::vector<Entry> entries;
  entries.reserve(table.size());
  for (auto&& [key, node] : table) entries.emplace_back(&key, &node);
  std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    const auto rank = [](const Entry& entry) {
      const toml::source_region& source = entry.first->source();
      return std::tuple(is_override(source), source.begin.line, source.begin.column);
    };
    return rank(a) < rank(b);
  });
  return entries;
}

void check_scene(const toml::table& root) {
  check_table(root, scene_table(), "");
}

}  // namespace fascicle::scene
