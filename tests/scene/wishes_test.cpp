// Settings for all flesh at once, and the commented scene file that `fascicle scenes` prints.
#include <cmath>
#include <functional>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/scene/scene_file.h"
#include "tests/scene/scene_samples.h"
#include "tests/support/assets.h"

namespace fascicle::tests::wishes_test {
namespace {

using scene::Scene;
using scene::SceneError;
using scene::SceneOverrides;

const char* const made_arm = "[character]\nmade = \"arm\"\n";
const char* const explicit_arm =
    "[character]\nmade = \"arm\"\n[solver]\nintegrator = \"explicit\"\nsubsteps = 4\n";

Scene parse(const std::string& text, const SceneOverrides& overrides = {}) {
  return scene::parse_scene({"test", "test.toml", text, {}}, overrides);
}

std::string message_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const SceneError& error) {
    return error.what();
  }
  return "";
}

TEST(Wishes, SoftnessDividesTheStiffnessOfWhatMovesByItself) {
  const Scene plain = parse(made_arm), soft = parse(made_arm, {.softness = 2.0});
  ASSERT_EQ(plain.layers.size(), soft.layers.size());
  std::size_t free = 0;
  for (std::size_t l = 0; l < plain.layers.size(); ++l) {
    if (plain.layers[l].kinematic) {
      EXPECT_EQ(plain.layers[l].youngs_modulus, soft.layers[l].youngs_modulus);
      continue;
    }
    ++free;
    EXPECT_EQ(*plain.layers[l].youngs_modulus, 2.0 * *soft.layers[l].youngs_modulus);
    EXPECT_EQ(plain.layers[l].damping, soft.layers[l].damping);
  }
  EXPECT_EQ(free, 2u);
}

// A frequency is proportional to the square root of stiffness; the keys of both integrators are softened.
TEST(Wishes, SoftnessHoldsForEveryWayToSayStiffness) {
  const std::string bar = "[bar]\n[layers.body]\n";
  EXPECT_EQ(*parse(bar + "frequency = 6.0\n", {.softness = 4.0}).layers[0].frequency, 3.0);
  EXPECT_EQ(*parse(bar + "material = \"fat\"\n", {.softness = 2.0}).layers[0].youngs_modulus, 1625.0);
  EXPECT_EQ(parse(bar + "alpha = 0.5\n", {.softness = 2.0}).layers[0].alpha, 0.25);
  const std::string firm = message_of([&] { parse(bar + "alpha = 0.75\n", {.softness = 0.5}); });
  EXPECT_NE(firm.find("--softness 0.5: flesh.softness: makes alpha of layers.body 1.5"), std::string::npos)
      << firm;
}

TEST(Wishes, ExaggerationMultipliesWhatFleshFeels) {
  const Scene twice = parse(made_arm, {.set = {"layers.fat.inertia_scale=0.5"}, .exaggerate = 2.0});
  for (const scene::Layer& layer : twice.layers)
    EXPECT_EQ(layer.inertia_scale, layer.kinematic ? 1.0 : layer.name == "fat" ? 1.0 : 2.0) << layer.name;
  const std::string far =
      message_of([] { parse(made_arm, {.set = {"layers.fat.inertia_scale=3"}, .exaggerate = 2.0}); });
  EXPECT_NE(far.find("makes inertia_scale of layers.fat 6, and 4 is the most"), std::string::npos) << far;
}

// They would do nothing.
TEST(Wishes, WhatTakesASkeletonIsRefusedWithoutOne) {
  const std::string bar = "[bar]\n[layers.body]\nalpha = 0.5\n";
  EXPECT_NE(
      message_of([&] { parse(bar, {.exaggerate = 2.0}); }).find("flesh.exaggerate: takes a [character]"),
      std::string::npos);
  EXPECT_NE(message_of([&] {
              parse(bar, {.set = {"motion.cut_distance=1"}});
            }).find("motion.cut_distance: takes a [character]"),
            std::string::npos);
  EXPECT_EQ(parse(bar, {.exaggerate = 1.0}).flesh.exaggerate, 1.0);
}

TEST(Wishes, OnlyNamesJointsWhateverTheyAreCalled) {
  const Scene scene = parse(made_arm, {.only = {"forearm", "say \"hand\""}});
  EXPECT_EQ(scene.skeleton.only, (std::vector<std::string>{"forearm", "say \"hand\""}));
  const std::string bar =
      message_of([] { parse("[bar]\n[layers.body]\nalpha = 0.5\n", {.only = {"forearm"}}); });
  EXPECT_NE(bar.find("--only forearm: the scene has no character"), std::string::npos) << bar;
}

// alpha belongs to the explicit integrator; setting it does not switch to that integrator.
TEST(Wishes, AnAlphaDoesNotSwitchTheIntegrator) {
  const std::string refused = message_of([] { parse(made_arm, {.set = {"layers.fat.alpha=0.2"}}); });
  EXPECT_NE(refused.find("layers.fat.alpha"), std::string::npos) << refused;
  EXPECT_NE(refused.find("flesh.softness"), std::string::npos) << refused;
  EXPECT_EQ(parse(explicit_arm, {.set = {"layers.fat.alpha=0.2"}}).layers[0].alpha, 0.2);
}

// Uncomments lines "#key = value".
std::string uncommented(const std::string& text) {
  std::istringstream in(text);
  std::string result;
  for (std::string line; std::getline(in, line);)
    result += (line.size() > 1 && line[0] == '#' && line[1] != ' ' ? line.substr(1) : line) + '\n';
  return result;
}

TEST(Wishes, TheDocumentedTextReadsAsTheSceneAlsoWithItsDefaultsSpelledOut) {
  for (const char* text : {made_arm, explicit_arm, "[bar]\n[layers.body]\nfrequency = 4.0\n"}) {
    const Scene scene = parse(text);
    const std::string documented = scene::documented_text(scene);
    EXPECT_EQ(describe(parse(documented)), describe(scene)) << documented;
    const std::string spelled_out = uncommented(documented);
    EXPECT_NE(spelled_out, documented);
    EXPECT_EQ(describe(parse(spelled_out)), describe(scene)) << spelled_out;
  }
}

// Every key that applies to the scene, by the schema and not by the table that generates both.
TEST(Wishes, TheDocumentedTextNamesEveryKey) {
  const std::string documented = scene::documented_text(parse(made_arm));
  const auto schema = nlohmann::json::parse(scene::scene_schema());
  std::size_t keys = 0;
  for (const char* table : {"scene", "character", "body", "skeleton", "flesh", "layer", "muscle", "solver",
                            "motion", "pin", "probe", "force"})
    for (const auto& [key, value] : schema["$defs"][table]["properties"].items()) {
      // These belong to the explicit integrator.
      if (key.starts_with("alpha")) continue;
      EXPECT_NE(documented.find(key), std::string::npos) << table << '.' << key;
      ++keys;
    }
  EXPECT_GT(keys, 60u);
  EXPECT_EQ(documented.find("[bar]"), std::string::npos);
  std::istringstream lines(documented);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 120u) << line;
}

}  // namespace
}  // namespace fascicle::tests::wishes_test
