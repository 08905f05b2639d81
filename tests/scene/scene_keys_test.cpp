// Every key of the scene file: misspelt, of a wrong type, out of range; and the JSON Schema, which must
// agree. The keys come from hand-written samples and from the schema's text, not from the table that
// generates both.
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <sstream>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/scene/scene_file.h"
#include "tests/scene/scene_samples.h"
#include "tests/support/assets.h"

namespace fascicle::tests {
namespace {

using nlohmann::json;
using scene::Scene;
using scene::SceneError;

const std::set<std::string> tables_of_named{"bones", "layers", "fibres", "muscle",
                                            "pin",   "probe",  "force",  "collider"};

// One line of a sample, and its key.
struct Line {
  std::size_t number = 0;  // from 0
  std::string text;
  std::vector<std::string> section;  // parts of the header that applies, or of this header
  std::string key;                   // empty for a header
};

struct Sample {
  std::vector<Line> lines;

  std::string text_with(std::size_t number, const std::string& replacement) const {
    std::string text;
    for (const Line& line : lines) text += (line.number == number ? replacement : line.text) + "\n";
    return text;
  }
};

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, '.');) parts.push_back(part);
  return parts;
}

Sample sample_of(const std::string& text) {
  Sample sample;
  std::istringstream in(text);
  std::vector<std::string> section;
  for (std::string line; std::getline(in, line);) {
    Line entry{sample.lines.size(), line, {}, {}};
    if (line.starts_with('[')) section = split(line.substr(1, line.size() - 2));
    if (const std::size_t equals = line.find(" = "); equals != std::string::npos)
      entry.key = line.substr(0, equals);
    if (line.starts_with('[') || !entry.key.empty()) entry.section = section;
    sample.lines.push_back(entry);
  }
  return sample;
}

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

// Puts the files that the mesh and character samples name into a temporary folder.
class SceneKeys : public ::testing::Test {
 protected:
  SceneKeys() {
    write_tetrahedron_off(folder_.path() / "tetrahedron.off");
    write_arm_paint(folder_.path() / "arm.paint.json");
    samples_.push_back(sample_of(bar_sample()));
    samples_.push_back(sample_of(mesh_sample()));
    if (std::filesystem::exists(character_))
      std::filesystem::copy(character_, folder_.path() / character_.filename());
    samples_.push_back(sample_of(character_sample()));
    samples_.push_back(sample_of(made_sample()));
    samples_.push_back(sample_of(made_surface_sample()));
    samples_.push_back(sample_of(implicit_sample()));
    samples_.push_back(sample_of(characters_sample()));
  }

  Scene parse(const std::string& text, const scene::SceneOverrides& overrides = {}) const {
    return scene::parse_scene({"sample", "sample.toml", text, folder_.path()}, overrides);
  }

  // The described scene, or the error.
  std::string outcome(const std::string& text) const {
    try {
      return describe(parse(text));
    } catch (const SceneError& error) {
      return error.what();
    }
  }

  // The message of the SceneError that `text` causes.
  std::string refusal(const std::string& text, const scene::SceneOverrides& overrides = {}) const {
    try {
      parse(text, overrides);
    } catch (const SceneError& error) {
      return error.what();
    }
    return "no error";
  }

  void for_each_line(const std::function<void(const Sample&, const Line&)>& use) const {
    for (const Sample& sample : samples_) {
      for (const Line& line : sample.lines) use(sample, line);
    }
  }

  TemporaryFolder folder_;
  std::vector<Sample> samples_;
  std::filesystem::path character_ = asset("CesiumMan.glb");
};

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

// Keys that require other keys, and names that need quotes.
TEST_F(SceneKeys, BonesJointsAndPaintNeedWhatHasThem) {
  const std::vector<std::pair<std::string, std::string>> refused{
      {"layers.fat.where.depth.maximum=0.5\nlayers.fat.where.depth.minimum=0.6", "neither TOML"},
      {"layers.fat.where={depth={minimum=0.6,maximum=0.5}}", "minimum is above maximum"},
      {"layers.fat.where={volume_share={minimum=0.6,maximum=0.5}}", "minimum is above maximum"},
      {"layers.fat.where={joints={names=[\"hand\"]}}", "only a [character]"},
      {"layers.fat.where={painted={attribute=\"_LAYER\",minimum=0,maximum=1}}", "only a [character]"},
      {"layers.fat.where={depth={maximum=0.5,per_bone={hand=0.3}}}", "only a [character]"},
      {"layers.fat.alpha_attribute=_STIFFNESS", "only a [character]"},
      {"contact.attribute=_CONTACT", "contact.attribute: only a [character]"},
      {"layers.fat.fibre_field=true", "conflicts with fibre_field"},
      {"fibres.biceps.points=[[0,0,0],[0,0,0]]", "the same point twice"},
      {"fibres.biceps.points=[[0,0,0],[0,2e6,0]]", "must be at most"},
      {"skeleton.connect=false", "only a [character]"}};
  for (const auto& [set, reason] : refused)
    EXPECT_NE(refusal(bar_sample(), {.set = {set}}).find(reason), std::string::npos)
        << refusal(bar_sample(), {.set = {set}});
  EXPECT_NE(refusal(mesh_sample(), {.set = {"layers.body.where={depth={maximum=0.5}}"}}).find("no bones"),
            std::string::npos);
}

TEST_F(SceneKeys, IgnoredContactIsListsOfOneOrTwoNames) {
  const std::vector<std::pair<std::string, std::string>> refused{
      {"[]", "contact.ignore: is empty; leave it out, or name something"},
      {"[\"tail\"]", "contact.ignore[0]: takes an array of one or two names, [\"a\", \"b\"], not text"},
      {"\"tail\"", "contact.ignore: takes an array of arrays of one or two texts in quotes, not text"},
      {"[[\"fat\"], []]",
       "contact.ignore[1]: has 0 names; give two that have no contact with each other, or one"},
      {"[[\"a\", \"b\", \"c\"]]", "contact.ignore[0]: has 3 names"},
      {"[[\"fat\", 2]]", "contact.ignore[0][1]: takes text in quotes, not a whole number"}};
  for (const auto& [value, reason] : refused)
    EXPECT_NE(refusal(bar_sample(), {.set = {"contact.ignore=" + value}}).find(reason), std::string::npos)
        << refusal(bar_sample(), {.set = {"contact.ignore=" + value}});
}

TEST_F(SceneKeys, MusclesNeedAJointOrABone) {
  const std::vector<std::pair<std::string, std::string>> refused{
      {"", "muscle.m.joint: is missing; name the joint"},
      {"bone = \"hand\"\naxis = \"flexion\"", "muscle.m.axis: applies to a muscle that follows a joint"},
      {"joint = \"hand\"\nlayer = \"bodi\"",
       "muscle.m.layer: there is no layer \"bodi\"; did you mean body?"},
      {"joint = \"foerarm\"", "sample.toml:4: muscle.m.joint: no joint is called \"foerarm\""},
      {"joint = \"hand\"\ncontraction_channel = \"hand.bend\"",
       "sample.toml:4: muscle.m.contraction_channel: \"hand.bend\" is not a channel"},
      {"joint = \"hand\"\nactivation = \"sine\"\ncurve = [[0, 0]]",
       "muscle.m.curve: conflicts with activation"},
      {"joint = \"hand\"\ncurve = [[1, 0], [1, 0]]", "muscle.m.curve[1]: does not come after"},
      {"joint = \"hand\"\ncurve = [[1, 0, 2]]", "muscle.m.curve[0]: has 3 entries"},
      {"joint = \"hand\"\ncurve = []", "muscle.m.curve: is empty"},
      {"joint = \"hand\"\ncontraction = [[0, 1]]\ncontraction_channel = \"a.scale.x\"",
       "muscle.m.contraction_channel: conflicts with contraction"}};
  for (const auto& [keys, reason] : refused)
    EXPECT_NE(refusal("[character]\nmade = \"arm\"\n[layers.body]\n[muscle.m]\n" + keys + "\n").find(reason),
              std::string::npos)
        << keys << ": " << refusal("[character]\nmade = \"arm\"\n[layers.body]\n[muscle.m]\n" + keys + "\n");
  EXPECT_NE(refusal("[bar]\n[layers.body]\n[muscle.m]\njoint = \"a\"\n").find("only a [character]"),
            std::string::npos);
}

TEST_F(SceneKeys, ACharacterNeedsNoLayers) {
  const Scene scene =
      parse("[character]\nmade = \"arm\"\n[muscle.m]\njoint = \"forearm\"\nlayer = \"muscle\"\n");
  ASSERT_EQ(scene.layers.size(), 3u);
  EXPECT_EQ(scene.layers[1].name, "muscle");
  EXPECT_EQ(scene.solver.integrator, scene::Integrator::implicit_step);
  EXPECT_EQ(describe(parse(scene.text)), describe(scene)) << "the text names what was added";
  EXPECT_NE(refusal("[bar]\n").find("layers: is missing"), std::string::npos);
}

// Physical units, unless the explicit integrator or an alpha is requested, by the scene or an override.
TEST_F(SceneKeys, ACharacterWithoutLayersGetsThemForItsIntegrator) {
  const std::string plain = "[character]\nmade = \"arm\"\n";
  for (const Scene& scene :
       {parse(plain), parse(plain + "[solver]\nintegrator = \"implicit\"\n"),
        parse(plain, {.set = {"solver.integrator=implicit"}}),
        parse(plain + "[solver]\nintegrator = \"explicit\"\n", {.set = {"solver.integrator=implicit"}})}) {
    ASSERT_EQ(scene.layers.size(), 3u);
    EXPECT_EQ(scene.solver.integrator, scene::Integrator::implicit_step);
    EXPECT_TRUE(scene.solver.auto_substeps);
    EXPECT_FALSE(scene.solver.iterations);
    // The paper's ratio of 0.3 between fat and muscle.
    EXPECT_NEAR(*scene.layers[0].youngs_modulus, 0.3 * *scene.layers[1].youngs_modulus,
                0.01 * *scene.layers[1].youngs_modulus);
  }
  for (const Scene& scene :
       {parse(plain + "[solver]\nintegrator = \"explicit\"\n"),
        parse(plain, {.set = {"solver.integrator=implicit", "solver.integrator=explicit"}}),
        parse(plain, {.set = {"solver.weights=kaneda2017"}}),
        parse(plain + "[solver]\nweights = \"kaneda2017\"\n")}) {
    EXPECT_EQ(scene.solver.integrator, scene::Integrator::explicit_step);
    EXPECT_TRUE(scene.solver.auto_substeps);
    EXPECT_EQ(scene.layers[1].alpha, 1.0);
  }
  const std::string set = "layers.fat.alpha=0.125";
  EXPECT_EQ(parse(plain, {.set = {"solver.integrator=explicit", set}}).layers[0].alpha, 0.125);
  EXPECT_EQ(
      refusal(plain, {.set = {set}}).find("--set " + set + ": layers.fat.alpha: takes solver.integrator"),
      0u);
}

// A bear is larger than an arm, and its clips last as long: waves must cross it in the same time.
TEST_F(SceneKeys, FleshOfACharacterWithoutLayersGoesByItsSize) {
  const Scene arm = parse("[character]\nmade = \"arm\"\n"), bear = parse("[character]\nmade = \"bear\"\n");
  const auto extent = [](const Scene& of) {
    Eigen::AlignedBox3d box;
    for (const scene::Vector3d& p : std::get<rig::Character>(of.geometry).surface.vertices) box.extend(p);
    return box.sizes().maxCoeff();
  };
  const double larger = extent(bear) / extent(arm);
  ASSERT_GT(larger, 1.5);
  for (const std::size_t l : {0u, 1u}) {
    // The values are written with three digits.
    EXPECT_NEAR(*bear.layers[l].youngs_modulus / *arm.layers[l].youngs_modulus, larger * larger,
                0.01 * larger * larger);
    EXPECT_EQ(bear.layers[l].damping, arm.layers[l].damping);
  }
}

// A scene without an integrator gets the one that fits the stiffness keys of its layers.
TEST_F(SceneKeys, LayersChooseTheIntegrator) {
  const auto integrator_of = [this](const std::string& body, const std::vector<std::string>& set) {
    return parse(
               "[bar]\n[layers.bone]\nkinematic = true\nwhere = { below = { axis = \"y\", fraction = 0.1 } "
               "}\n"
               "[layers.body]\n" +
                   body,
               {.set = set})
        .solver.integrator;
  };
  EXPECT_EQ(integrator_of("", {}), scene::Integrator::explicit_step);
  EXPECT_EQ(integrator_of("alpha = 0.5\n", {}), scene::Integrator::explicit_step);
  for (const char* stated : {"youngs_modulus = 1e4\n", "frequency = 5.0\n", "material = \"fat\"\n"})
    EXPECT_EQ(integrator_of(stated, {}), scene::Integrator::implicit_step) << stated;
  EXPECT_EQ(integrator_of("alpha = 0.5\n", {"layers.body.frequency=5"}), scene::Integrator::implicit_step);
  EXPECT_EQ(integrator_of("frequency = 5.0\n", {"layers.body.alpha=0.5"}), scene::Integrator::explicit_step);
}

// A layer gives its stiffness by exactly one key, which its integrator must accept.
TEST_F(SceneKeys, StiffnessIsStatedOnceAndByItsIntegrator) {
  const auto with = [](const std::string& line) {
    return implicit_sample() + "\n[layers.more]\n" + line + "\n";
  };
  const std::string where = "where = { everywhere = true }\n";
  EXPECT_NE(refusal(with("youngs_modulus = 1.0\nfrequency = 2.0\n" + where))
                .find("frequency: conflicts with youngs_modulus"),
            std::string::npos);
  EXPECT_NE(refusal(with("material = \"fat\"\nfrequency = 2.0\n" + where)).find("conflicts with"),
            std::string::npos);
  EXPECT_NE(refusal(with("frequency = 2.0\ndamping = 1.0\ndamping_ratio = 0.5\n" + where))
                .find("conflicts with damping"),
            std::string::npos);
  EXPECT_NE(refusal(with(where)).find("layers.more: has no stiffness"), std::string::npos);
  EXPECT_NE(refusal(with("alpha = 0.5\n" + where))
                .find("layers.more.alpha: takes solver.integrator = \"explicit\""),
            std::string::npos);
  EXPECT_EQ(refusal(with("kinematic = true\n" + where)), "no error");
  EXPECT_EQ(refusal(with("frequency = 2.0\nsliding = true\n" + where)), "no error");
  EXPECT_EQ(refusal(with("frequency = 2.0\nleast_volume = 0.3\n" + where)), "no error");
  const std::string slides = refusal(with("kinematic = true\nsliding = true\n" + where));
  EXPECT_NE(slides.find("sliding: is for flesh that moves by itself"), std::string::npos) << slides;
  EXPECT_NE(refusal(with("kinematic = true\nfrequency = 2.0\n" + where)).find("a kinematic layer does not"),
            std::string::npos);
  const std::vector<std::pair<std::string, std::string>> refused{
      {"layers.fat.youngs_modulus=1e4", "layers.fat.youngs_modulus: takes solver.integrator = \"implicit\""},
      {"layers.fat.least_volume=0.3", "layers.fat.least_volume: takes solver.integrator = \"implicit\""},
      {"layers.fat.damping_ratio=0.5", "layers.fat.damping_ratio: takes solver.integrator = \"implicit\""},
      {"solver.substeps=many", "is not one of auto"},
      {"solver.iterations=5", "solver.iterations: takes"},
      {"solver.quality=final", "solver.quality: takes"},
      {"solver.viscosity=0.001", "solver.viscosity: takes"}};
  EXPECT_NE(refusal(implicit_sample(), {.set = {"solver.substeps=auto", "solver.iterations=1"}})
                .find("solver.iterations: is 1, which resolves no stiffness"),
            std::string::npos);
  EXPECT_NE(
      refusal(implicit_sample(), {.set = {"solver.substeps=4"}}).find("solver.quality: applies only with"),
      std::string::npos);
  EXPECT_EQ(refusal(implicit_sample(), {.set = {"solver.substeps=4"}, .quality = "final"}), "no error");
  for (const auto& [set, reason] : refused)
    EXPECT_NE(refusal(bar_sample(), {.set = {set}}).find(reason), std::string::npos)
        << refusal(bar_sample(), {.set = {set}});
  // --set of one key replaces the other.
  const Scene in_hertz =
      parse(implicit_sample(), {.set = {"layers.fat.frequency=5", "layers.fat.damping=2"}});
  EXPECT_FALSE(in_hertz.layers[0].youngs_modulus);
  EXPECT_EQ(in_hertz.layers[0].frequency, 5.0);
  EXPECT_FALSE(in_hertz.layers[0].damping_ratio);
  EXPECT_EQ(in_hertz.layers[0].damping, 2.0);
  const Scene by_name = parse(implicit_sample(), {.set = {"layers.fat.material=relaxed-muscle"}});
  EXPECT_EQ(by_name.layers[0].youngs_modulus, 7000.0);
  EXPECT_EQ(by_name.layers[0].density, 1040.0);
}

TEST_F(SceneKeys, NamesThatNeedQuotesAreWrittenBack) {
  FASCICLE_NEEDS_ASSET(character_);
  const Scene once = parse(character_sample(), {.set = {"character.resolution=0.1"}});
  EXPECT_NE(once.text.find("leg joint.R"), std::string::npos);
  EXPECT_EQ(describe(parse(once.text)), describe(once));
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
