#include "host/scene/overrides.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "host/scene/parse_toml.h"
#include "host/scene/scene_check.h"

namespace fascicle::scene {
namespace {

// One assignment: what the user wrote, and the key it sets.
struct Assignment {
  std::string option;  // "--set layers.fat.alpha=0.2"; stands for the file name in messages
  std::vector<std::string> path;
  std::string value;
  std::uint32_t ordinal = 1;

  std::string path_text() const {
    std::string text;
    for (const std::string& part : path) text = join_path(text, part);
    return text;
  }
  toml::source_region source() const {
    const toml::source_position position{ordinal, 1};
    return {position, position, std::make_shared<const std::string>(option)};
  }
};

// The value as TOML. It becomes a string of the same characters if it is not valid TOML, or if the key takes
// text (a clip named 1). Returned inside its document, under the key `value`, because nodes lose their source
// location when copied.
toml::table parse_value(const Assignment& assignment, const Key& key) {
  try {
    toml::table document = parse_toml("value = " + assignment.value, assignment.option);
    // More than one key means that the value contained a line break and more TOML after it.
    if (document.size() == 1 && (key.type != KeyType::text || document.get("value")->is_string()))
      return document;
  } catch (const SceneError&) {
  }
  try {
    // A TOML comment accepts exactly the text that a string may hold: UTF-8 without control characters.
    if (parse_toml("# " + assignment.value, assignment.option).empty()) {
      toml::table document = parse_toml("value = ''", assignment.option);
      document.get("value")->as_string()->get() = assignment.value;
      return document;
    }
  } catch (const SceneError&) {
  }
  fail(assignment.source(), assignment.path_text(), "the value is neither TOML nor one line of UTF-8 text");
}

void drop_alternatives(toml::table& table, const Table& keys, std::string_view name) {
  for (const auto* groups : {&keys.choices, &keys.alternatives})
    for (const auto& choice : *groups) {
      if (std::find(choice.begin(), choice.end(), name) == choice.end()) continue;
      for (const std::string& other : choice) {
        if (other != name) table.erase(other);
      }
    }
}

// Follows the assignment's path through the tables and sets the value at its end.
void assign(toml::table& root, const Assignment& assignment) {
  toml::table* table = &root;
  const Table* keys = &scene_table();
  const Key* key = nullptr;
  bool naming = false;  // the table's keys are user-chosen names, of tables like key->table
  std::string path;
  for (std::size_t i = 0; i < assignment.path.size(); ++i) {
    const std::string& part = assignment.path[i];
    const bool last = i + 1 == assignment.path.size();
    if (!naming) {
      key = find_key(*keys, part);
      if (key == nullptr) fail_unknown(assignment.source(), path, part, key_names(*keys));
      drop_alternatives(*table, *keys, part);
    } else if (!last && !table->contains(part)) {
      std::vector<std::string> names;
      for (const auto& entry : in_order(*table)) names.emplace_back(entry.first->str());
      fail_unknown(assignment.source(), path, part, names);
    }
    path = join_path(path, part);
    if (last) {
      toml::table document = parse_value(assignment, *key);
      document.get("value")->visit([&](auto& value) {
        table->insert_or_assign(toml::key(part, assignment.source()), std::move(value));
      });
      return;
    }
    if (key->table == nullptr) fail(assignment.source(), path, "has no keys inside; set it whole");
    if (!table->contains(part)) table->insert_or_assign(toml::key(part, assignment.source()), toml::table{});
    table = table->get(part)->as_table();
    if (table == nullptr) fail(assignment.source(), path, "is not one table; set it whole");
    if (!naming) keys = key->named != nullptr && holds_named_tables(*key, *table) ? key->named : key->table;
    naming = !naming && holds_named_tables(*key, *table);
  }
}

std::vector<std::string> split_path(std::string_view text) {
  std::vector<std::string> parts;
  while (true) {
    const std::size_t dot = text.find('.');
    parts.emplace_back(text.substr(0, dot));
    if (dot == std::string_view::npos) return parts;
    text.remove_prefix(dot + 1);
  }
}

// "30" frames or "0.5s" as seconds.
std::string preroll_seconds(const std::string& text, const toml::table& root) {
  const bool in_seconds = text.ends_with('s');
  const char* last = text.data() + text.size() - (in_seconds ? 1 : 0);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), last, value);
  if (error != std::errc() || end != last || (!in_seconds && value != std::floor(value)))
    throw SceneError(one_line("--preroll " + text + ": takes frames, such as 30, or seconds, such as 0.5s"));
  if (in_seconds) return shortest(value);
  const auto fps = root["scene"]["fps"].value<double>();
  return shortest(value / fps.value_or(Scene{}.fps));
}

}  // namespace

bool has_named_characters(const toml::table& root) {
  const toml::table* table = root["character"].as_table();
  return table != nullptr && holds_named_tables(*find_key(scene_table(), "character"), *table);
}

bool has_overrides(const SceneOverrides& o) {
  return !o.set.empty() || o.fps || o.start || o.end || o.clip || o.rest || o.interpolation || o.preroll ||
         o.settle || o.loop || o.seamless || o.hold || o.handles || o.cage || o.cage_detail || o.resolution ||
         o.quality || !o.rigid.empty() || o.softness || o.exaggerate || !o.only.empty();
}

std::optional<std::string> overridden(const SceneOverrides& overrides, std::string_view path) {
  std::optional<std::string> value;
  for (const std::string& text : overrides.set) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || std::string_view(text).substr(0, equals) != path) continue;
    value = text.substr(equals + 1);
    if (value->size() >= 2 && (value->front() == '"' || value->front() == '\'') &&
        value->back() == value->front())
      value = value->substr(1, value->size() - 2);
  }
  return value;
}

void apply_overrides(toml::table& root, const SceneOverrides& overrides) {
  std::uint32_t ordinal = 0;
  const auto set = [&](std::string option, std::string_view path, std::string value) {
    assign(root, {std::move(option), split_path(path), std::move(value), ++ordinal});
  };
  for (const std::string& text : overrides.set) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw SceneError(one_line("--set " + text + ": takes KEY.PATH=VALUE, such as layers.fat.alpha=0.2"));
    }
    set("--set " + text, std::string_view(text).substr(0, equals), text.substr(equals + 1));
  }
  const auto assign_number = [&](const char* option, const char* path, const std::optional<double>& value) {
    if (value) set(std::string(option) + " " + shortest(*value), path, shortest(*value));
  };
  assign_number("--fps", "scene.fps", overrides.fps);
  assign_number("--start", "scene.start", overrides.start);
  assign_number("--end", "scene.end", overrides.end);
  if (overrides.rest) set("--rest " + *overrides.rest, "motion.rest", *overrides.rest);
  if (overrides.interpolation)
    set("--interpolation " + *overrides.interpolation, "motion.interpolation", *overrides.interpolation);
  if (overrides.preroll)
    set("--preroll " + *overrides.preroll, "motion.preroll", preroll_seconds(*overrides.preroll, root));
  assign_number("--settle", "motion.settle", overrides.settle);
  assign_number("--softness", "flesh.softness", overrides.softness);
  assign_number("--exaggerate", "flesh.exaggerate", overrides.exaggerate);
  if (!overrides.only.empty()) {
    std::string option, value;
    for (const std::string& joint : overrides.only) {
      option += (option.empty() ? "--only " : " --only ") + joint;
      value += (value.empty() ? "[" : ", ") + toml_string(joint);
    }
    if (!root.contains("character"))
      throw SceneError(one_line(option + ": the scene has no character, so there is no joint to choose"));
    set(option, "skeleton.only", value + "]");
  }
  assign_number("--hold", "motion.hold", overrides.hold);
  if (overrides.handles) {
    const std::string count = std::to_string(*overrides.handles);
    set("--handles " + count, "motion.handles", count);
  }
  if (overrides.loop) {
    const std::string count = std::to_string(*overrides.loop);
    set("--loop " + count, "motion.loop", count);
  }
  if (overrides.seamless) set("--seamless", "motion.seamless", "true");
  if (overrides.clip) {
    const std::string option = "--clip " + *overrides.clip;
    if (!root.contains("character"))
      throw SceneError(one_line(option + ": the scene has no character, so there is no clip to choose"));
    if (has_named_characters(root))
      throw SceneError(one_line(option +
                                ": the scene has characters by name; say whose clip it is: --set character." +
                                std::string(in_order(*root["character"].as_table()).front().first->str()) +
                                ".clip=" + *overrides.clip));
    set(option, "character.clip", *overrides.clip);
  }
  const auto assign_text = [&](const char* option, const char* path,
                               const std::optional<std::string>& value) {
    if (value) set(std::string(option) + " " + *value, path, *value);
  };
  if (!overrides.rigid.empty()) {
    toml::array names;
    std::string option = "--rigid";
    for (const std::string& name : overrides.rigid) {
      names.push_back(name);
      option += " " + name;
    }
    if (!root.contains("character"))
      throw SceneError(one_line(option + ": the scene has no character, so there is nothing to be rigid"));
    std::ostringstream text;
    text << toml::toml_formatter{names};
    set(option, "skeleton.rigid", text.str());
  }
  // The quality only matters for "auto", so a scene that states its steps would ignore it.
  for (const char* key : {"quality", "substeps", "iterations"})
    if (overrides.quality)
      set("--quality " + *overrides.quality, std::string("solver.") + key,
          key == std::string_view("quality") ? *overrides.quality : "auto");
  assign_text("--cage", "body.cage", overrides.cage);
  assign_text("--cage-detail", "body.cage_detail", overrides.cage_detail);
  assign_text("--resolution", "body.resolution", overrides.resolution);
  if (overrides.resolution) {
    for (const char* source : {"mesh", "character"})
      if (toml::table* table = root.get_as<toml::table>(source)) {
        if (!has_named_characters(root)) table->erase("resolution");
        for (auto&& [name, one] : *table)
          if (toml::table* inner = one.as_table()) inner->erase("resolution");
      }
  }
}

}  // namespace fascicle::scene
