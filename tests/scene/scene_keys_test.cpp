// Every key of the scene file: misspelt, of a wrong type, out of range; and the JSON Schema, which must
// agree. The keys come from hand-written samples and from the schema's text, not from the table that
// generates both.

#include "tests/scene/scene_keys.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/scene/scene.h"
#include "tests/scene/scene_samples.h"
#include "tests/support/assets.h"

namespace fascicle::tests {
namespace {

using nlohmann::json;

const std::set<std::string> tables_of_named{"bones", "layers", "fibres", "muscle",
                                            "pin",   "probe",  "force",  "collider"};

std::string join(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : ".") + part;
  return text;
}

// Whether the second part is a user-chosen name; with several characters, keys are below their names.
bool is_by_name(const std::vector<std::string>& parts) {
  if (parts.size() > 1 && parts[0] == "character")
    return parts.size() > 2 || parts[1] == "left" || parts[1] == "right";
  return parts.size() > 1 && tables_of_named.contains(parts[0]);
}

// "layers.fat.alpha" to "layers.NAME.alpha"
std::string general(std::vector<std::string> parts) {
  if (is_by_name(parts)) parts[1] = "NAME";
  return join(parts);
}

// A number's type may be paired with text, for keys that also take words.
std::string type_of(const json& property) {
  return property["type"].is_array() ? property["type"][0] : property["type"];
}

std::string mistyped(std::string name) {
  std::size_t last = name.size() - 1;
  while (name[last] == name[last - 1]) --last;
  std::swap(name[last], name[last - 1]);
  return name;
}

std::set<std::string> keys_of_samples(const std::vector<Sample>& samples) {
  std::set<std::string> keys;
  for (const Sample& sample : samples) {
    for (const Line& line : sample.lines) {
      for (std::size_t n = 1; n <= line.section.size(); ++n) {
        keys.insert(general({line.section.begin(), line.section.begin() + static_cast<std::ptrdiff_t>(n)}));
      }
      if (line.key.empty()) continue;
      auto parts = line.section;
      parts.push_back(line.key);
      keys.insert(general(parts));
    }
  }
  for (const std::string& table : tables_of_named) keys.erase(table + ".NAME");
  keys.erase("character.NAME");
  return keys;
}

// Any `where` may hold any shape, and either half space has the same keys; the samples show each once.
std::string shape_key(const std::string& key) {
  std::string short_key = key;
  if (const std::size_t where = key.find(".where."); where != std::string::npos)
    short_key = "WHERE" + key.substr(where + 6);
  if (const std::size_t above = short_key.find("above."); above != std::string::npos)
    short_key.replace(above, 5, "below");
  return short_key;
}

// {path: property} of the schema.
std::map<std::string, json> properties_of_schema() {
  const json schema = json::parse(scene::scene_schema());
  std::map<std::string, json> found;
  const std::function<void(const json&, const std::string&)> walk = [&](const json& node,
                                                                        const std::string& path) {
    if (node.contains("$ref")) {
      const auto reference = node["$ref"].get<std::string>();
      ASSERT_TRUE(reference.starts_with("#/"));
      walk(schema.at(json::json_pointer(reference.substr(1))), path);
      return;
    }
    if (node.contains("oneOf") && !node.contains("properties"))
      for (const json& one : node["oneOf"]) walk(one, path);
    if (node.contains("additionalProperties") && node["additionalProperties"].is_object()) {
      walk(node["additionalProperties"], path + ".NAME");
    }
    if (!node.contains("properties")) return;
    EXPECT_EQ(node["additionalProperties"], false) << path;
    for (const auto& [name, property] : node["properties"].items()) {
      const std::string inner = path.empty() ? name : path + "." + name;
      found[inner] = property;
      walk(property, inner);
    }
  };
  walk(schema, "");
  return found;
}

TEST_F(SceneKeys, SamplesAreAccepted) {
  EXPECT_EQ(refusal(bar_sample()), "no error");
  EXPECT_EQ(refusal(mesh_sample()), "no error");
  EXPECT_EQ(refusal(made_sample()), "no error");
  FASCICLE_NEEDS_ASSET(character_);
  EXPECT_EQ(refusal(character_sample()), "no error");
  EXPECT_EQ(refusal(characters_sample()), "no error");
}

TEST_F(SceneKeys, SchemaListsTheSamplesKeysAndNothingElse) {
  const json schema = json::parse(scene::scene_schema());
  EXPECT_EQ(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
  std::set<std::string> in_schema, in_samples;
  for (const auto& [path, property] : properties_of_schema()) {
    in_schema.insert(shape_key(path));
    EXPECT_TRUE(property.contains("description")) << path;
  }
  for (const std::string& key : keys_of_samples(samples_)) in_samples.insert(shape_key(key));
  EXPECT_EQ(in_schema, in_samples);
}

TEST_F(SceneKeys, MistypedKeysAreRefusedWithLineAndNearestName) {
  std::size_t tried = 0;
  for_each_line([&](const Sample& sample, const Line& line) {
    if (line.key.empty()) return;
    const std::string text =
        sample.text_with(line.number, mistyped(line.key) + line.text.substr(line.key.size()));
    const std::string start = "sample.toml:" + std::to_string(line.number + 1) + ": " + join(line.section) +
                              "." + mistyped(line.key) + ": unknown; did you mean " + line.key + "?";
    EXPECT_EQ(refusal(text).substr(0, start.size()), start);
    ++tried;
  });
  EXPECT_GE(tried, 50u);
}

TEST_F(SceneKeys, MistypedTablesAreRefusedWithLineAndNearestName) {
  for_each_line([&](const Sample& sample, const Line& line) {
    if (!line.key.empty()) return;
    for (std::size_t i = 0; i < line.section.size(); ++i) {
      if (i == 1 && is_by_name(line.section)) continue;
      auto parts = line.section;
      parts[i] = mistyped(parts[i]);
      const std::string message = refusal(sample.text_with(line.number, "[" + join(parts) + "]"));
      const std::vector<std::string> up_to(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(i) + 1);
      const std::string start = "sample.toml:" + std::to_string(line.number + 1) + ": " + join(up_to) +
                                ": unknown; did you mean " + line.section[i] + "?";
      EXPECT_EQ(message.substr(0, start.size()), start);
    }
  });
}

TEST_F(SceneKeys, WrongTypesAreRefusedWithLine) {
  const auto schema = properties_of_schema();
  for_each_line([&](const Sample& sample, const Line& line) {
    if (line.key.empty()) return;
    auto parts = line.section;
    parts.push_back(line.key);
    const json& property = schema.at(general(parts));
    const std::string type = type_of(property);
    std::vector<std::string> wrong{"1979-05-27", "{}", "[[1.0]]"};
    if (type != "string") wrong.push_back("\"1\"");
    if (type != "boolean") wrong.push_back("true");
    if (type != "number" && type != "integer") wrong.push_back("1");
    if (type != "number") wrong.push_back("1.5");
    if (type == "array") {
      wrong.insert(wrong.end(), {"[2, 2, \"2\"]", "[2, 2, nan]"});
      if (property.contains("maxItems")) wrong.insert(wrong.end(), {"[]", "[2, 2]", "[2, 2, 2, 2]"});
      if (property["items"]["type"] == "integer") wrong.push_back("[2, 2, 2.5]");
    }
    if (type == "number") wrong.insert(wrong.end(), {"nan", "inf", "-inf", "+nan"});
    for (const std::string& value : wrong) {
      const std::string start = "sample.toml:" + std::to_string(line.number + 1) + ": " + join(parts);
      EXPECT_EQ(refusal(sample.text_with(line.number, line.key + " = " + value)).substr(0, start.size()),
                start)
          << value;
    }
  });
}

TEST_F(SceneKeys, TablesOfWrongTypeAreRefused) {
  for (const auto& [path, property] : properties_of_schema()) {
    const bool is_table =
        property.contains("$ref") || property.contains("oneOf") || property["type"] == "object";
    if (!is_table || path.find("WHERE") != std::string::npos) continue;
    std::string set = path;
    // Names in the bar sample that exist whatever the rest of the path is.
    const std::map<std::string, std::string> names{
        {"bones", "thigh"}, {"layers", "fat"}, {"fibres", "biceps"}, {"muscle", "biceps"},
        {"pin", "box"},     {"probe", "ball"}, {"force", "push"},    {"collider", "floor"}};
    const std::string first = split(path)[0];
    if (const std::size_t name = set.find("NAME"); name != std::string::npos)
      set.replace(name, 4, names.at(first));
    for (const std::string value : {"3", "\"text\"", "[]", "[1]"}) {
      const std::string option = "--set " + set + "=" + value;
      const std::string start = option + ": " + set;
      const std::string sample = first == "muscle" ? made_sample() : bar_sample();
      EXPECT_EQ(refusal(sample, {.set = {set + "=" + value}}).substr(0, start.size()), start);
    }
  }
}

// The nearest double or integer just outside a bound of the schema.
std::string beyond(const json& bounds, bool minimum) {
  const bool whole = type_of(bounds) == "integer";
  std::ostringstream out;
  out.precision(17);
  if (minimum && bounds.contains("exclusiveMinimum")) {
    out << std::showpoint << bounds["exclusiveMinimum"].get<double>();
  } else if (const char* name = minimum ? "minimum" : "maximum"; !bounds.contains(name)) {
    return {};
  } else if (whole) {
    out << bounds[name].get<std::int64_t>() + (minimum ? -1 : 1);
  } else {
    const double far = minimum ? -INFINITY : INFINITY;
    out << std::showpoint << std::nextafter(bounds[name].get<double>(), far);
  }
  return out.str();
}

std::string at_bound(const json& bounds, bool minimum) {
  const char* name = minimum ? "minimum" : "maximum";
  return bounds.contains(name) ? bounds[name].dump() : std::string{};
}

TEST_F(SceneKeys, ValuesOutOfTheSchemasRangeAreRefusedAndItsBoundsAreNot) {
  const auto schema = properties_of_schema();
  std::size_t tried = 0;
  for_each_line([&](const Sample& sample, const Line& line) {
    if (line.key.empty()) return;
    auto parts = line.section;
    parts.push_back(line.key);
    const json& property = schema.at(general(parts));
    const bool is_vector = property["type"] == "array";
    const json& bounds = is_vector ? property["items"] : property;
    const auto with = [&](const std::string& value) {
      const std::string whole_value = is_vector ? "[" + value + ", " + value + ", " + value + "]" : value;
      return refusal(sample.text_with(line.number, line.key + " = " + whole_value));
    };
    const std::string start = "sample.toml:" + std::to_string(line.number + 1) + ": " + join(parts);
    for (const bool minimum : {true, false}) {
      if (const std::string value = beyond(bounds, minimum); !value.empty()) {
        const std::string message = with(value);
        EXPECT_EQ(message.substr(0, start.size()), start) << value;
        EXPECT_NE(message.find("must be"), std::string::npos) << message;
        ++tried;
      }
      // The bound itself may conflict with other keys (end with start), but not with the range.
      if (const std::string value = at_bound(bounds, minimum); !value.empty()) {
        EXPECT_EQ(with(value).find("must be"), std::string::npos) << start << " " << value;
      }
    }
    if (property.contains("enum")) {
      EXPECT_EQ(with("\"nonesuch\"").substr(0, start.size()), start);
      ++tried;
    }
  });
  EXPECT_GE(tried, 60u);
}

TEST_F(SceneKeys, RangesThatTheMethodNeeds) {
  const std::vector<std::string> refused{"layers.fat.alpha=1.01",
                                         "layers.fat.alpha=-0.01",
                                         "layers.fat.beta=1.01",
                                         "layers.fat.beta=-0.01",
                                         "layers.fat.damping=-1",
                                         "layers.fat.density=0",
                                         "bar.jitter=0.31",
                                         "bar.vertices=[1, 5, 5]",
                                         "bar.size=[0, 1, 1]",
                                         "solver.substeps=0",
                                         "solver.substeps=1001",
                                         "scene.fps=0",
                                         "layers.fat.fibre=[0, 0, 0]",
                                         "layers.fat.inertia_scale=4.01",
                                         "layers.fat.volume=1.01",
                                         "layers.fat.volume=-0.01",
                                         "motion.loop=0",
                                         "motion.preroll=-0.1",
                                         "motion.settle=-1",
                                         "motion.hold=-1",
                                         "motion.handles=-1",
                                         "motion.cut_distance=0"};
  for (const std::string& set : refused) {
    const std::string start = "--set " + set + ": ";
    EXPECT_EQ(refusal(bar_sample(), {.set = {set}}).substr(0, start.size()), start);
  }
  const std::vector<std::string> accepted{
      "layers.fat.alpha=0",   "layers.fat.alpha=1", "layers.fat.beta=0",      "layers.fat.beta=1",
      "layers.fat.damping=0", "bar.jitter=0.3",     "bar.vertices=[2, 2, 2]", "solver.substeps=1000"};
  for (const std::string& set : accepted) EXPECT_EQ(refusal(bar_sample(), {.set = {set}}), "no error") << set;
}

TEST_F(SceneKeys, AbsentKeysMeanTheSchemasDefaults) {
  FASCICLE_NEEDS_ASSET(character_);
  const auto schema = properties_of_schema();
  std::set<std::string> with_default, tried;
  for (const auto& [path, property] : schema) {
    if (property.contains("default")) with_default.insert(shape_key(path));
  }
  for_each_line([&](const Sample& sample, const Line& line) {
    if (line.key.empty()) return;
    auto parts = line.section;
    parts.push_back(line.key);
    const json& property = schema.at(general(parts));
    if (!property.contains("default")) return;
    const std::string given = line.key + " = " + property["default"].dump();
    EXPECT_EQ(outcome(sample.text_with(line.number, "")), outcome(sample.text_with(line.number, given)))
        << given;
    tried.insert(shape_key(general(parts)));
  });
  EXPECT_EQ(tried, with_default);
}

}  // namespace
}  // namespace fascicle::tests
