#include "host/scene/scene_edit.h"

#include <algorithm>
#include <utility>

#include "host/base/text.h"
#include "host/scene/overrides.h"
#include "host/scene/parse_toml.h"
#include "host/scene/scene_check.h"
#include "host/scene/scene_writer.h"

namespace fascicle::scene {
namespace {

// ---- Values

// A name as it appears before an equals sign.
std::string name_text(const std::string& name) {
  return is_valid_name(name) ? name : toml_string(name);
}

std::string toml_text(const Json& value, bool whole) {
  switch (value.type()) {
    case Json::value_t::string:
      return toml_string(value.get<std::string>());
    case Json::value_t::boolean:
      return value.get<bool>() ? "true" : "false";
    case Json::value_t::number_integer:
    case Json::value_t::number_unsigned:
    case Json::value_t::number_float: {
      const auto number = value.get<double>();
      if (value.is_number_integer()) return value.dump() + (whole ? "" : ".0");
      const std::string text = shortest(number);
      return text + (text.find_first_of(".einf") == std::string::npos ? ".0" : "");
    }
    case Json::value_t::array: {
      std::string text;
      for (const Json& one : value) text += (text.empty() ? "[" : ", ") + toml_text(one, whole);
      return text.empty() ? "[]" : text + "]";
    }
    case Json::value_t::object: {
      std::string text;
      for (const auto& [name, one] : value.items())
        text +=
            (text.empty() ? "{ " : ", ") + name_text(name) + " = " + toml_text(one, one.is_number_integer());
      return text.empty() ? "{}" : text + " }";
    }
    default:
      throw SceneError("a value must not be null; to remove a key, leave it out");
  }
}

Json json_of_node(const toml::node& node) {
  if (const auto* table = node.as_table()) {
    Json object = Json::object();
    for (const auto& [name, value] : in_order(*table))
      object[std::string(name->str())] = json_of_node(*value);
    return object;
  }
  if (const auto* array = node.as_array()) {
    Json list = Json::array();
    for (const toml::node& one : *array) list.push_back(json_of_node(one));
    return list;
  }
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* whole = node.as_integer()) return whole->get();
  if (const auto* number = node.as_floating_point()) return number->get();
  if (const auto* truth = node.as_boolean()) return truth->get();
  return nullptr;  // a date, which no key takes
}

// The text's content for comparison. The order of tables counts, as layers depend on it; that of other keys
// does not.
Json without_order(const toml::table& table) {
  Json tables = Json::array();
  nlohmann::json others = nlohmann::json::object();
  for (const auto& [name, node] : in_order(table))
    if (const auto* inner = node->as_table())
      tables.push_back({std::string(name->str()), without_order(*inner)});
    else
      others[std::string(name->str())] = nlohmann::json(json_of_node(*node));
  return {others, tables};
}

// ---- Tables of the text

bool is_table_key(const Key& key) {
  return key.type == KeyType::table || key.type == KeyType::named_tables;
}

std::vector<std::string> rivals_of(const Table& keys, const std::string& name) {
  std::vector<std::string> rivals;
  for (const auto* groups : {&keys.choices, &keys.alternatives})
    for (const auto& group : *groups) {
      if (std::find(group.begin(), group.end(), name) == group.end()) continue;
      for (const std::string& other : group)
        if (other != name && std::find(rivals.begin(), rivals.end(), other) == rivals.end())
          rivals.push_back(other);
    }
  return rivals;
}

void add_table(const toml::table& table, const Table& keys, const std::string& path,
               std::vector<EditedTable>& all) {
  EditedTable edited{path, &keys, {}};
  std::vector<std::pair<const Key*, const toml::table*>> inner;
  for (const Key& key : keys.keys) {
    if (is_table_key(key)) continue;
    const toml::node* node = table.get(key.name);
    // A single shape is split into its own table, so that its numbers can be moved.
    if (key.type == KeyType::tables && node != nullptr && node->is_table()) {
      inner.emplace_back(&key, node->as_table());
      continue;
    }
    edited.keys.push_back({.path = join_path(path, key.name),
                           .key = &key,
                           .value = node != nullptr ? json_of_node(*node) : Json(key.fallback),
                           .is_stated = node != nullptr,
                           .rivals = rivals_of(keys, key.name)});
  }
  all.push_back(std::move(edited));
  for (const auto& [key, where] : inner)
    for (const auto& [name, shape] : in_order(*where)) {
      const Key* of_shape = find_key(*key->table, name->str());
      if (of_shape != nullptr && of_shape->type == KeyType::table && shape->is_table())
        add_table(*shape->as_table(), *of_shape->table, join_path(join_path(path, key->name), name->str()),
                  all);
    }
}

// ---- Changes in the text

// Converts the lines and columns of toml++ into offsets in the text.
class Places {
 public:
  explicit Places(std::string_view text) : text_(text) {
    lines_.push_back(0);
    for (std::size_t at = 0; at < text.size(); ++at)
      if (text[at] == '\n') lines_.push_back(at + 1);
  }
  std::size_t offset(const toml::source_position& position) const {
    if (position.line == 0 || position.line > lines_.size()) return text_.size();
    std::size_t at = lines_[position.line - 1];
    for (std::uint32_t column = 1; column < position.column && at < text_.size(); ++column) {
      std::string_view rest = text_.substr(at);
      const std::size_t before = rest.size();
      base::take_code_point(rest);
      at += before - rest.size();
    }
    return at;
  }
  std::size_t line_begin(std::size_t at) const {
    return *std::prev(std::upper_bound(lines_.begin(), lines_.end(), at));
  }
  // The offset after the line's end.
  std::size_t line_end(std::size_t at) const {
    const std::size_t end = text_.find('\n', at);
    return end == std::string_view::npos ? text_.size() : end + 1;
  }

 private:
  std::string_view text_;
  std::vector<std::size_t> lines_;
};

struct Found {
  const toml::table* table = nullptr;  // the table that holds it, or would hold it
  const toml::key* name = nullptr;     // null: not in the table
  const toml::node* value = nullptr;
};

// Finds the table that contains the path's last key, if the text has such a table.
Found find(const toml::table& root, std::span<const std::string> path) {
  const toml::table* table = &root;
  for (std::size_t k = 0; k + 1 < path.size(); ++k) {
    const toml::node* next = table->get(path[k]);
    table = next != nullptr ? next->as_table() : nullptr;
    if (table == nullptr) return {};
  }
  Found found{table, nullptr, nullptr};
  for (const auto& [name, value] : in_order(*table))
    if (name->str() == path.back()) {
      found.name = name;
      found.value = value;
    }
  return found;
}

// One change of the text. Returns nullopt for layouts that it cannot edit in place.
class Splice {
 public:
  Splice(std::string_view text, const toml::table& root, std::vector<std::string> path)
      : text_(text), places_(text), root_(root), path_(std::move(path)), found_(find(root, path_)) {}

  std::optional<std::string> removed() const {
    if (found_.name == nullptr) return std::string(text_);
    return without(*found_.name, *found_.value);
  }

  // `value` as TOML. If an object becomes a table of its own, each of its keys gets a line.
  std::optional<std::string> set(const Json& value, bool whole,
                                 const std::vector<std::string>& rivals) const {
    const std::string plain = name_text(path_.back()) + " = " + toml_text(value, whole);
    if (found_.name != nullptr) {
      if (found_.value->is_table() && !found_.value->as_table()->is_inline()) return std::nullopt;
      return replaced(places_.offset(found_.name->source().begin), places_.offset(found_.value->source().end),
                      plain);
    }
    if (found_.table != nullptr)
      for (const auto& [name, node] : in_order(*found_.table)) {
        if (std::find(rivals.begin(), rivals.end(), name->str()) == rivals.end()) continue;
        return replaced(places_.offset(name->source().begin), places_.offset(node->source().end), plain);
      }
    if (value.is_object() && (found_.table == nullptr || !found_.table->is_inline()))
      return appended_table(value);
    if (found_.table == nullptr) return appended("[" + header(path_.size() - 1) + "]\n" + plain + "\n");
    if (found_.table->is_inline()) return into_inline(plain);
    return into_table(plain);
  }

 private:
  std::string header(std::size_t parts) const {
    std::string text;
    for (std::size_t k = 0; k < parts; ++k) text += (k == 0 ? "" : ".") + name_text(path_[k]);
    return text;
  }
  std::string replaced(std::size_t begin, std::size_t end, const std::string& with) const {
    return std::string(text_.substr(0, begin)) + with + std::string(text_.substr(end));
  }
  std::string appended(const std::string& what) const {
    std::string result(text_);
    while (!result.empty() && result.back() == '\n') result.pop_back();
    return result + (result.empty() ? "" : "\n\n") + what;
  }
  std::string appended_table(const Json& value) const {
    std::string lines = "[" + header(path_.size()) + "]\n";
    for (const auto& [name, one] : value.items())
      lines += name_text(name) + " = " + toml_text(one, one.is_number_integer()) + "\n";
    return appended(lines);
  }

  // Removes the whole line if nothing else is on it.
  std::optional<std::string> without(const toml::key& name, const toml::node& node) const {
    const std::size_t begin = places_.offset(name.source().begin), end = places_.offset(node.source().end);
    const std::size_t line = places_.line_begin(begin), next = places_.line_end(end);
    const std::string_view before = text_.substr(line, begin - line), after = text_.substr(end, next - end);
    const std::size_t more = after.find_first_not_of(" \t\r\n");
    const bool is_alone = before.find_first_not_of(" \t") == std::string_view::npos &&
                          (more == std::string_view::npos || after[more] == '#');
    if (!is_alone) return std::nullopt;
    return replaced(line, next, "");
  }

  std::optional<std::string> into_inline(const std::string& plain) const {
    const std::size_t end = places_.offset(found_.table->source().end);
    if (end == 0 || end > text_.size() || text_[end - 1] != '}') return std::nullopt;
    return replaced(end - 1, end, (found_.table->empty() ? " " : ", ") + plain + " }");
  }

  // Inserts after the last of the table's own keys, or else after its header.
  std::optional<std::string> into_table(const std::string& plain) const {
    std::size_t last = 0;
    bool has_own = false;
    for (const auto& [name, node] : in_order(*found_.table)) {
      const auto* inner = node->as_table();
      if (inner != nullptr && !inner->is_inline()) continue;
      has_own = true;
      last = std::max(last, places_.offset(node->source().end));
    }
    if (!has_own) {
      if (found_.table == &root_) return plain + "\n" + std::string(text_);
      const std::size_t headline = places_.offset(found_.table->source().begin);
      if (headline >= text_.size() || text_[headline] != '[') return std::nullopt;
      last = headline;
    }
    const std::size_t next = places_.line_end(last);
    const bool ends_in_newline = next > 0 && text_[next - 1] == '\n';
    return replaced(next, next, (ends_in_newline ? "" : "\n") + plain + "\n");
  }

  std::string_view text_;
  Places places_;
  const toml::table& root_;
  std::vector<std::string> path_;
  Found found_;
};

std::vector<std::string> parts_of(const std::string& path) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (;;) {
    const std::size_t dot = path.find('.', begin);
    parts.push_back(path.substr(begin, dot - begin));
    if (dot == std::string::npos) return parts;
    begin = dot + 1;
  }
}

// The key that a path refers to in the table of keys, with its rivals. Null if there is none.
struct Described {
  const Key* key = nullptr;
  std::vector<std::string> rivals;
};
Described described(const std::vector<std::string>& path) {
  const Table* keys = &scene_table();
  const Key* key = nullptr;
  for (std::size_t k = 0; k < path.size() && keys != nullptr; ++k) {
    key = find_key(*keys, path[k]);
    if (key == nullptr) return {};
    if (k + 1 == path.size()) return {key, rivals_of(*keys, key->name)};
    // Skip a name that the user chose.
    const bool is_named =
        key->type == KeyType::named_tables || (key->named != nullptr && path.size() - k > 2);
    keys = is_named && key->named != nullptr ? key->named : key->table;
    if (is_named && ++k + 1 == path.size()) return {key, {}};
  }
  return {};
}

void take_out(toml::table& root, const std::vector<std::string>& path) {
  toml::table* table = &root;
  for (std::size_t k = 0; k + 1 < path.size(); ++k) {
    table = table->get_as<toml::table>(path[k]);
    if (table == nullptr) return;
  }
  table->erase(path.back());
}

// Drops the option's name from the front of a message, since the caller reports the key.
[[noreturn]] void rethrow_without(const SceneError& error, const std::string& option) {
  const std::string text = error.what(), prefix = option + ": ";
  throw SceneError(text.starts_with(prefix) ? text.substr(prefix.size()) : text);
}

void apply(toml::table& root, const KeyChange& change, const std::vector<std::string>& path, bool whole) {
  if (!change.value) {
    take_out(root, path);
    check_scene(root);
    return;
  }
  const std::string assignment = change.path + "=" + toml_text(*change.value, whole);
  try {
    apply_overrides(root, {.set = {assignment}});
    check_scene(root);
  } catch (const SceneError& error) {
    rethrow_without(error, one_line("--set " + assignment));
  }
}

}  // namespace

std::vector<EditedTable> edited_tables(const std::string& text, const std::string& source) {
  const toml::table root = parse_toml(text, source);
  // The text may be a stranger's. What follows relies on the types of its values.
  check_scene(root);
  static const toml::table empty;
  std::vector<EditedTable> all;
  for (const Key& key : scene_table().keys) {
    const toml::node* node = root.get(key.name);
    const toml::table* table = node != nullptr ? node->as_table() : nullptr;
    if (table != nullptr && holds_named_tables(key, *table)) {
      for (const auto& [name, inner] : in_order(*table))
        add_table(*inner->as_table(), key.named != nullptr ? *key.named : *key.table,
                  join_path(key.name, name->str()), all);
    } else if (key.type == KeyType::table) {
      // The text has one of several kinds of body; omit the keys of the others.
      const bool is_rival = table == nullptr && !rivals_of(scene_table(), key.name).empty();
      if (!is_rival) add_table(table != nullptr ? *table : empty, *key.table, key.name, all);
    }
  }
  return all;
}

ChangedText change_text(std::string_view text, const std::string& source,
                        std::span<const KeyChange> changes) {
  ChangedText result{std::string(text), true};
  for (const KeyChange& change : changes) {
    toml::table root = parse_toml(result.text, source);
    const std::vector<std::string> path = parts_of(change.path);
    const Described key = described(path);
    const bool whole =
        key.key != nullptr && (key.key->type == KeyType::integer || key.key->type == KeyType::integer_vector);
    std::optional<std::string> spliced;
    {
      // Source regions refer to the parsed text, so splice before changing the tree.
      const Splice splice(result.text, root, path);
      if (key.key != nullptr)
        spliced = change.value ? splice.set(*change.value, whole, key.rivals) : splice.removed();
    }
    apply(root, change, path, whole);
    const Json wanted = without_order(root);
    // Fails if other rivals remain besides the replaced one, or if the layout is unusual.
    const auto reads_as_wanted = [&] {
      if (!spliced) return false;
      try {
        const toml::table again = parse_toml(*spliced, source);
        check_scene(again);
        return without_order(again) == wanted;
      } catch (const SceneError&) {
        return false;
      }
    };
    if (reads_as_wanted()) {
      result.text = *spliced;
    } else {
      result.keeps_comments = result.keeps_comments && result.text.find('#') == std::string::npos;
      result.text = write_scene(root);
    }
  }
  return result;
}

}  // namespace fascicle::scene
