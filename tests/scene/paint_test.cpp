// Paint files: reading, errors, and their effect on scenes.
#include <functional>
#include <map>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/made/made_character.h"
#include "host/scene/input_files.h"
#include "host/scene/paint_file.h"
#include "host/scene/scene_json.h"
#include "host/scene/scene_paint.h"
#include "tests/scene/scene_samples.h"
#include "tests/scene/scene_texts.h"
#include "tests/support/assets.h"

namespace fascicle::tests::paint_test {
namespace {

using nlohmann::json;
using namespace scene;

const std::string by_alpha =
    "[layers.fat]\nalpha = 0.3\n[layers.muscle]\nalpha = 1.0\nwhere = { depth = { maximum = 0.65 } }\n"
    "[layers.bone]\nkinematic = true\nwhere = { depth = { maximum = 0.3 } }\n";

rig::Paint paint_of(const rig::Character& character, std::vector<rig::PaintedVertices> attributes) {
  rig::Paint paint;
  paint.surface = rig::surface_hash(character.surface);
  paint.vertices = character.surface.vertices.size();
  paint.attributes = std::move(attributes);
  return paint;
}

// A folder with a paint file of the generated arm.
struct PaintedArm {
  TemporaryFolder folder;
  rig::Character arm = made::make_character("arm");

  explicit PaintedArm(std::vector<rig::PaintedVertices> attributes) { write(std::move(attributes)); }
  void write(std::vector<rig::PaintedVertices> attributes) const {
    folder.write("arm.paint.json", paint_text(paint_of(arm, std::move(attributes))));
  }
  Scene scene(const std::string& layers, const SceneOverrides& overrides = {}) const {
    return parse("[character]\nmade = \"arm\"\npaint = \"arm.paint.json\"\n" + layers, overrides,
                 folder.path());
  }
  std::string refusal(const std::string& layers) const {
    try {
      scene(layers);
    } catch (const SceneError& error) {
      return error.what();
    }
    return "no error";
  }
};

const std::vector<double>& values_of(const rig::Character& character, const std::string& name) {
  for (const rig::PaintedAttribute& attribute : character.painted)
    if (attribute.name == name) return attribute.values;
  throw std::runtime_error(name + " is not painted");
}
const std::vector<double>& values_of(const Scene& scene, const std::string& name) {
  return values_of(std::get<rig::Character>(scene.geometry), name);
}

TEST(PaintFile, IsReadBackAsItWasWritten) {
  const rig::Character arm = made::make_character("arm");
  const rig::Paint paint = paint_of(arm, {{"_RIGID", {7}, {1.0f}},
                                          {"_LAYER", {0, 5}, {3.0f, 2.0f}},
                                          {"_STIFFNESS", {1, 2, 3}, {0.1f, 1.0f / 3.0f, 0.7654321f}},
                                          {"_FIBER", {4, 6}, {0.6f, 0.8f, 0.0f, 0.0f, 0.0f, -1.0f}}});
  const rig::Paint read = parse_paint(paint_text(paint), "a.json", arm.surface);
  EXPECT_EQ(read.surface, paint.surface);
  EXPECT_EQ(read.vertices, paint.vertices);
  ASSERT_EQ(read.attributes.size(), 4u);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(read.attributes[k].name, paint.attributes[k].name);
    EXPECT_EQ(read.attributes[k].vertex, paint.attributes[k].vertex);
    EXPECT_EQ(read.attributes[k].value, paint.attributes[k].value) << "bit-exact";
  }
  EXPECT_EQ(parse_paint(paint_text(paint_of(arm, {})), "a.json", arm.surface).attributes.size(), 0u);
}

// Each kind of damage, with the place that the message must name.
TEST(PaintFile, IsRefusedByFileAndPlace) {
  const rig::Character arm = made::make_character("arm");
  const std::string good = paint_text(
      paint_of(arm, {{"_LAYER", {1, 2, 9}, {3.0f, 2.0f, 1.0f}}, {"_FIBER", {4}, {0.6f, 0.8f, 0.0f}}}));
  ASSERT_NO_THROW(parse_paint(good, "a.json", arm.surface));
  const auto refusal = [&](const std::string& text) -> std::string {
    try {
      parse_paint(text, "a.json", arm.surface);
    } catch (const InputFileError& error) {
      return error.what();
    }
    return "no error";
  };
  const std::map<std::string, std::function<void(json&)>> damages{
      {"a.json: /fascicle_paint: is missing", [](json& d) { d.erase("fascicle_paint"); }},
      {"a.json: /fascicle_paint: is not 1", [](json& d) { d["fascicle_paint"] = 2; }},
      {"a.json: /surface: is \"0123\", and the character's mesh has", [](json& d) { d["surface"] = "0123"; }},
      {"a.json: /vertices: is 4, and the character has", [](json& d) { d["vertices"] = 4; }},
      {"a.json: /more: is unknown", [](json& d) { d["more"] = 1; }},
      {"a.json: /attributes: takes an object", [](json& d) { d["attributes"] = 1; }},
      {"a.json: /attributes/_LAYR: cannot be painted; _RIGID, _LAYER, _STIFFNESS and _FIBER can; did you "
       "mean _LAYER?",
       [](json& d) { d["attributes"]["_LAYR"] = d["attributes"]["_LAYER"]; }},
      {"a.json: /attributes/_LAYER: takes an object", [](json& d) { d["attributes"]["_LAYER"] = {1}; }},
      {"a.json: /attributes/_LAYER/value: is missing",
       [](json& d) { d["attributes"]["_LAYER"].erase("value"); }},
      {"a.json: /attributes/_LAYER/value: has 2 numbers for 3 vertices; must be 1 per vertex",
       [](json& d) { d["attributes"]["_LAYER"]["value"].erase(0); }},
      {"a.json: /attributes/_FIBER/value: has 1 number for 1 vertex; must be 3 per vertex",
       [](json& d) { d["attributes"]["_FIBER"]["value"] = {1}; }},
      {"a.json: /attributes/_LAYER/vertex/2: is vertex 999999 of",
       [](json& d) { d["attributes"]["_LAYER"]["vertex"][2] = 999999; }},
      {"a.json: /attributes/_LAYER/vertex/1: is not above the one before it",
       [](json& d) { d["attributes"]["_LAYER"]["vertex"][1] = 1; }},
      {"a.json: /attributes/_LAYER/vertex/0: takes a whole number",
       [](json& d) { d["attributes"]["_LAYER"]["vertex"][0] = -1; }},
      {"a.json: /attributes/_LAYER/value/1: takes a number",
       [](json& d) { d["attributes"]["_LAYER"]["value"][1] = nullptr; }},
      {"a.json: /attributes/_LAYER/value/1: is 2.5; takes a whole number",
       [](json& d) { d["attributes"]["_LAYER"]["value"][1] = 2.5; }},
      {"a.json: /attributes/_LAYER/value/1: is 256; must be from 0 to 255",
       [](json& d) { d["attributes"]["_LAYER"]["value"][1] = 256; }},
      {"a.json: /attributes/_FIBER/value/0: begins a direction of length 0.89; must be 1",
       [](json& d) { d["attributes"]["_FIBER"]["value"][0] = 0.4; }}};
  for (const auto& [message, damage] : damages) {
    json document = json::parse(good);
    damage(document);
    EXPECT_EQ(refusal(document.dump()).substr(0, message.size()), message);
  }
  EXPECT_EQ(refusal("").substr(0, 29), "a.json: /: not valid JSON, or");
  EXPECT_EQ(refusal(std::string(100000, '[')).substr(0, 29), "a.json: /: not valid JSON, or");
  EXPECT_EQ(refusal("[]"), "a.json: /: takes an object");
}

// Truncated anywhere or with any byte changed, it gives a paint or an InputFileError.
TEST(PaintFile, DamageIsNoCrash) {
  const rig::Character arm = made::make_character("arm");
  const std::string good = paint_text(paint_of(arm, {{"_FIBER", {4}, {0.6f, 0.8f, 0.0f}}}));
  const auto read = [&](const std::string& text) {
    try {
      parse_paint(text, "a.json", arm.surface);
    } catch (const InputFileError&) {
    }
  };
  for (std::size_t k = 0; k < good.size(); ++k) {
    read(good.substr(0, k));
    for (const char c : {'"', '9', '-', '\x80', '{'}) {
      std::string text = good;
      text[k] = c;
      read(text);
    }
  }
}

TEST(ScenePaint, GoesBeforeWhatTheCharacterHas) {
  rig::Character arm = made::make_character("arm");
  const std::size_t count = arm.surface.vertices.size();
  arm.painted = {{"_LAYER", 1, std::vector<double>(count, 2.0)}};
  rig::lay_over(
      paint_of(arm,
               {{"_LAYER", {3}, {1.0f}}, {"_STIFFNESS", {4}, {0.25f}}, {"_FIBER", {5}, {0.0f, 1.0f, 0.0f}}}),
      arm);
  for (std::size_t v = 0; v < count; ++v) {
    EXPECT_EQ(values_of(arm, "_LAYER")[v], v == 3 ? 1.0 : 2.0) << "unpainted vertices keep their values";
    EXPECT_EQ(values_of(arm, "_STIFFNESS")[v], v == 4 ? 0.25 : 1.0) << "unpainted flesh is not softer";
    EXPECT_EQ(values_of(arm, "_FIBER")[3 * v + 1], v == 5 ? 1.0 : 0.0);
  }
  arm.painted = {{"_FIBER", 4, std::vector<double>(4 * count, 0.0)}};
  EXPECT_THROW(rig::lay_over(paint_of(arm, {{"_FIBER", {5}, {0.0f, 1.0f, 0.0f}}}), arm), SceneError);
}

TEST(ScenePaint, IsAnInputOfTheScene) {
  const PaintedArm painted({{"_RIGID", {3}, {1.0f}}});
  const Scene scene = painted.scene(by_alpha);
  EXPECT_EQ(values_of(scene, "_RIGID")[3], 1.0);
  EXPECT_EQ(values_of(scene, "_RIGID")[2], 0.0);
  ASSERT_EQ(scene.input_hashes.size(), 1u);
  EXPECT_EQ(scene.input_hashes[0].first, (painted.folder.path() / "arm.paint.json").string());
  EXPECT_EQ(json_of(scene)["paint"], "arm.paint.json");
  painted.write({{"_RIGID", {4}, {1.0f}}});
  EXPECT_NE(painted.scene(by_alpha).input_hashes[0].second, scene.input_hashes[0].second);
  const Scene plain = parse("[character]\nmade = \"arm\"\n" + by_alpha);
  EXPECT_FALSE(json_of(plain).contains("paint")) << "manifests of scenes without paint have no such key";
  const Scene set = parse("[character]\nmade = \"arm\"\n" + by_alpha,
                          {.set = {"character.paint=arm.paint.json"}}, painted.folder.path());
  EXPECT_EQ(values_of(set, "_RIGID")[4], 1.0);
  EXPECT_TRUE(painted.scene(by_alpha, {.set = {"character.paint=\"\""}}).input_hashes.empty());
}

TEST(ScenePaint, OfAnotherMeshIsRefusedWithThePlaceOfTheKey) {
  const PaintedArm painted({{"_RIGID", {3}, {1.0f}}});
  const auto refusal = [&](const std::string& character) -> std::string {
    try {
      parse("[character]\nmade = \"" + character + "\"\npaint = \"arm.paint.json\"\n" + by_alpha, {},
            painted.folder.path());
    } catch (const SceneError& error) {
      return error.what();
    }
    return "no error";
  };
  const std::string start =
      "sample.toml:3: character.paint: " + (painted.folder.path() / "arm.paint.json").string() + ": /";
  EXPECT_EQ(refusal("bear").substr(0, start.size() + 8), start + "vertices");
  // The same number of vertices, but one has moved.
  rig::Character moved = painted.arm;
  moved.surface.vertices[5][1] += 1e-9;
  painted.folder.write("arm.paint.json", paint_text(paint_of(moved, {{"_RIGID", {3}, {1.0f}}})));
  EXPECT_EQ(refusal("arm").substr(0, start.size() + 7), start + "surface");
  std::filesystem::remove(painted.folder.path() / "arm.paint.json");
  EXPECT_NE(refusal("arm").find("does not exist"), std::string::npos);
}

// The numbers in _LAYER are matched to layers by name if no `where` refers to paint.
TEST(ScenePaint, LayersAreTakenByNameWhereNoneAsksForPaint) {
  const PaintedArm painted({{"_LAYER", {3, 4}, {3.0f, 1.0f}}});
  const Scene scene = painted.scene(by_alpha);
  ASSERT_EQ(scene.layers.size(), 3u);
  const auto range_of = [&](std::size_t l) {
    const auto& shape = std::get<Painted>(scene.layers[l].by_paint.at(0));
    return std::pair(shape.minimum, shape.maximum);
  };
  EXPECT_EQ(range_of(0), std::pair(2.5, 3.5)) << "fat";
  EXPECT_TRUE(scene.layers[1].by_paint.empty()) << "unpainted muscle";
  EXPECT_EQ(range_of(2), std::pair(0.5, 1.5)) << "bone";
  EXPECT_TRUE(scene.layers[0].where.empty()) << "the rest of the body is unchanged";

  const std::string start =
      "sample.toml:3: character.paint: paints _LAYER 3, which no layer uses; name a layer ";
  const std::string body =
      "[layers.body]\nalpha = 0.5\n[layers.bone]\nkinematic = true\n"
      "where = { depth = { maximum = 0.3 } }\n";
  EXPECT_EQ(painted.refusal(body).substr(0, start.size()), start);
  const std::string asks =
      "[layers.more]\nalpha = 0.1\n"
      "where = { painted = { attribute = \"_LAYER\", minimum = 3, maximum = 3 } }\n";
  EXPECT_EQ(painted.refusal(body + asks), "no error") << "the scene itself defines the paint";
  for (const Layer& layer : painted.scene(by_alpha + asks).layers)
    EXPECT_TRUE(layer.by_paint.empty()) << layer.name;
}

TEST(ScenePaint, StiffnessMultipliesWhatLayersSay) {
  const PaintedArm painted({{"_STIFFNESS", {3}, {0.5f}}});
  const Scene scene = painted.scene(by_alpha);
  EXPECT_EQ(scene.layers[0].alpha_attribute, "_STIFFNESS");
  EXPECT_EQ(scene.layers[1].alpha_attribute, "_STIFFNESS");
  EXPECT_EQ(scene.layers[2].alpha_attribute, "") << "bone has no alpha to multiply";
  const Scene said = painted.scene(by_alpha, {.set = {"layers.fat.alpha_attribute=_STIFFNESS"}});
  EXPECT_EQ(said.layers[0].alpha_attribute, "_STIFFNESS");
  EXPECT_EQ(said.layers[1].alpha_attribute, "") << "the scene itself defines where it acts";
  const Scene physical = painted.scene(
      "[layers.fat]\nmaterial = \"fat\"\n[layers.muscle]\nfrequency = 4.0\nwhere = { depth = { maximum = "
      "0.65 } }\n"
      "[layers.bone]\nkinematic = true\nwhere = { depth = { maximum = 0.3 } }\n");
  EXPECT_EQ(physical.solver.integrator, Integrator::implicit_step);
  EXPECT_EQ(physical.layers[0].alpha_attribute, "_STIFFNESS");
  EXPECT_EQ(physical.layers[1].alpha_attribute, "_STIFFNESS");
  EXPECT_EQ(physical.layers[2].alpha_attribute, "");
}

// alpha is at most 1; a factor on a modulus may be larger.
TEST(ScenePaint, AboveOneIsForModuli) {
  const PaintedArm painted({{"_STIFFNESS", {3, 4}, {0.5f, 4.0f}}});
  EXPECT_EQ(painted.refusal("[layers.fat]\nmaterial = \"fat\"\n"), "no error");
  const std::string start =
      "sample.toml:3: character.paint: paints _STIFFNESS up to 4, but here it multiplies alpha";
  EXPECT_EQ(painted.refusal(by_alpha).substr(0, start.size()), start);
}

// Like a character whose own file has the same paint.
TEST(ScenePaint, ACharacterWithoutLayersGoesByIt) {
  const PaintedArm stiff({{"_STIFFNESS", {3}, {0.5f}}});
  const Scene multiplied = stiff.scene("");
  EXPECT_EQ(multiplied.solver.integrator, Integrator::implicit_step) << "paint does not change the solver";
  EXPECT_EQ(multiplied.layers[0].alpha_attribute, "_STIFFNESS");
  EXPECT_EQ(multiplied.layers[0].youngs_modulus,
            PaintedArm({{"_RIGID", {3}, {0.5f}}}).scene("").layers[0].youngs_modulus);
  // The paper's solver multiplies alpha instead.
  const Scene by_paper = stiff.scene("", {.set = {"solver.integrator=explicit"}});
  EXPECT_EQ(by_paper.layers[0].alpha_attribute, "_STIFFNESS");
  EXPECT_FALSE(by_paper.layers[0].youngs_modulus);
  const PaintedArm layered({{"_LAYER", {3}, {2.0f}}});
  const Scene scene = layered.scene("");
  EXPECT_EQ(scene.solver.integrator, Integrator::implicit_step);
  for (const Layer& layer : scene.layers) {
    EXPECT_EQ(layer.where.size(), 2u) << "a shape, and paint";
    EXPECT_TRUE(layer.by_paint.empty());
  }
  // A scene with its paint given by --set, and one that is just a character's file.
  const SceneOverrides set{.set = {"character.paint=" + (stiff.folder.path() / "arm.paint.json").string()}};
  EXPECT_EQ(parse("[character]\nmade = \"arm\"\n", set).layers[0].alpha_attribute, "_STIFFNESS");
}

TEST(ScenePaint, ABareFileGoesByIt) {
  const std::filesystem::path man = asset("CesiumMan.glb");
  FASCICLE_NEEDS_ASSET(man);
  const TemporaryFolder folder;
  const Scene plain = load_scene(man.string());
  const rig::Paint paint = paint_of(std::get<rig::Character>(plain.geometry), {{"_STIFFNESS", {3}, {0.5f}}});
  const std::filesystem::path file = folder.write("man.paint.json", paint_text(paint));
  const Scene painted = load_scene(man.string(), {.set = {"character.paint=" + file.string()}});
  EXPECT_EQ(plain.solver.integrator, Integrator::implicit_step);
  EXPECT_EQ(painted.solver.integrator, Integrator::implicit_step);
  EXPECT_TRUE(painted.contact.self);
  EXPECT_EQ(painted.layers[0].alpha_attribute, "_STIFFNESS");
  EXPECT_EQ(painted.input_hashes.size(), plain.input_hashes.size() + 1);
  folder.write("man.paint.json", "{}");
  try {
    load_scene(man.string(), {.set = {"character.paint=" + file.string()}});
    ADD_FAILURE() << "input without paint was accepted as paint";
  } catch (const SceneError& error) {
    EXPECT_NE(std::string(error.what()).find("character.paint: " + file.string() + ": /fascicle_paint"),
              std::string::npos)
        << error.what();
  }
}

TEST(ScenePaint, OfOneOfSeveralIsItsOwn) {
  const PaintedArm painted({{"_LAYER", {3}, {3.0f}}});
  const std::string two =
      "[character.left]\nmade = \"bear\"\n[character.right]\nmade = \"arm\"\n"
      "paint = \"arm.paint.json\"\n";
  const Scene scene = parse(two + by_alpha, {}, painted.folder.path());
  const std::size_t first = scene.characters[0].own.surface.vertices.size();
  const std::vector<double>& layer = values_of(scene, "_LAYER");
  for (std::size_t v = 0; v < layer.size(); ++v) ASSERT_EQ(layer[v], v == first + 3 ? 3.0 : 0.0);
  EXPECT_EQ(json_of(scene)["characters"][1]["paint"], "arm.paint.json");
  EXPECT_FALSE(json_of(scene)["characters"][0].contains("paint"));

  painted.write({{"_STIFFNESS", {3}, {0.5f}}});
  // Unpainted flesh has the stiffness of its layer, also on another character.
  const Scene stiff = parse(two + by_alpha, {}, painted.folder.path());
  const std::vector<double>& share = values_of(stiff, "_STIFFNESS");
  for (std::size_t v = 0; v < share.size(); ++v) ASSERT_EQ(share[v], v == first + 3 ? 0.5 : 1.0);
}

// A given text replaces the file, which is then not read.
TEST(ScenePaint, ATextCanStandForTheFile) {
  const PaintedArm painted({{"_RIGID", {3}, {1.0f}}});
  LoadedFiles files;
  const auto rigid = [&] {
    const std::string text = "[character]\nmade = \"arm\"\npaint = \"arm.paint.json\"\n" + by_alpha;
    const Scene scene = parse_scene({"sample", "sample.toml", text, painted.folder.path(), &files}, {});
    const std::vector<double>& values = values_of(scene, "_RIGID");
    return std::find(values.begin(), values.end(), 1.0) - values.begin();
  };
  EXPECT_EQ(rigid(), 3);
  painted.write({{"_RIGID", {4}, {1.0f}}});
  EXPECT_EQ(rigid(), 3);
  const std::filesystem::path other = painted.folder.path() / "." / "arm.paint.json";
  EXPECT_EQ(files.text_of(other, most_paint_bytes),
            files.text_of(painted.folder.path() / "arm.paint.json", most_paint_bytes))
      << "another spelling is the same file";
  const std::filesystem::path file = painted.folder.path() / "arm.paint.json";
  files.give(file, paint_text(paint_of(painted.arm, {{"_RIGID", {5}, {1.0f}}})));
  EXPECT_EQ(rigid(), 5);
  files.give(file, std::nullopt);
  EXPECT_EQ(rigid(), 3);
}

}  // namespace
}  // namespace fascicle::tests::paint_test
