// The built-in characters, built into models: TetGen accepts their skins (it refuses self-intersecting ones),
// and each layer has its share.
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "host/scene/scene_file.h"
#include "tests/build/scenes.h"

namespace fascicle::tests {
namespace {

class MadeScenes : public testing::TestWithParam<const char*> {};

TEST_P(MadeScenes, AreBuiltWithoutAWarning) {
  build::BuildOptions options;
  options.mesher = std::filesystem::path(FASCICLE_BINARY_DIR) / "fascicle-mesher";
  const scene::Scene scene = scene::load_scene(GetParam());
  build::Report report;
  const model::Model model = build::build_model(scene, report, options);
  for (const build::Warning& warning : report.warnings) ADD_FAILURE() << warning.text;
  EXPECT_TRUE(model.has_skeleton());
  const auto& character = std::get<rig::Character>(scene.geometry);
  EXPECT_EQ(model.surface_count(), character.surface.vertices.size());
  ASSERT_EQ(report.layers.size(), 3u);
  for (const build::LayerShare& layer : report.layers)
    EXPECT_GT(layer.volume, 0.02 * report.volume) << layer.name;
  EXPECT_GT(report.pinned_vertices, 0u);
  // The limit for `do bake`: a bake of a few seconds.
  EXPECT_LT(report.vertices, 12000u);
}

// A setting that leaves almost nothing to simulate gives a warning; one that leaves a forearm does not.
TEST(OnlyWarning, SaysHowLittleIsSimulated) {
  const auto said_of = [](const std::string& joint) {
    scene::Scene scene = scene::load_scene("arm");
    scene.skeleton.only = {joint};
    scene.body.vertices = 1200;
    scene.probes.clear();
    scene.muscles.clear();
    build::Report report;
    build::build_model(scene, report, with_mesher());
    for (const build::Warning& warning : report.warnings)
      if (warning.text.find("vertices are simulated") != std::string::npos) return warning.text;
    return std::string();
  };
  const std::string of_hand = said_of("hand");
  EXPECT_NE(of_hand.find("skeleton.only: only "), std::string::npos) << of_hand;
  EXPECT_NE(of_hand.find("joint above hand"), std::string::npos) << of_hand;
  EXPECT_EQ(said_of("upper_arm"), "");
}

// The report of a scene with several characters has the sums, extremes and findings of all of them.
TEST(SeveralCharacters, HaveOneReport) {
  const auto report_of = [](const std::string& characters) {
    const std::string layers =
        "[layers.flesh]\n[layers.bone]\nkinematic = true\nwhere.bone_distance = {maximum = 0.018}\n";
    build::Report report;
    build::build_model(scene::parse_scene({"test", "test.toml", characters + layers, {}}, {}), report,
                       with_mesher());
    return report;
  };
  const std::string arm = "made = \"arm\"\nresolution = 0.02\n";
  const build::Report one = report_of("[character]\n" + arm);
  const build::Report two = report_of("[character.a]\n" + arm + "[character.b]\n" + arm + "at = [0, 1, 0]\n");
  const build::CageReport &of_one = one.fill.cage, &of_two = two.fill.cage;
  EXPECT_TRUE(of_one.has_skin);
  EXPECT_TRUE(of_two.has_skin);
  EXPECT_EQ(of_two.is_cage, of_one.is_cage);
  EXPECT_NE(of_two.reason.find("a: "), std::string::npos) << of_two.reason;
  EXPECT_NE(of_two.reason.find("; b: "), std::string::npos) << of_two.reason;
  // Moved by a metre, coordinates are rounded otherwise, by 2^-53 of about 1.
  EXPECT_NEAR(of_two.skin_volume, 2.0 * of_one.skin_volume, 1e-12);
  EXPECT_NEAR(of_two.edges.low, of_one.edges.low, 1e-12);
  EXPECT_NEAR(of_two.edges.high, of_one.edges.high, 1e-12);
  EXPECT_NEAR(two.volume, 2.0 * one.volume, 1e-12);
  EXPECT_EQ(two.vertices, 2 * one.vertices);
  // Each character's joints are below one that stands for its place.
  EXPECT_EQ(two.joints.size(), 2 * (one.joints.size() + 1));
}

// An arm as long as a house: the warning gives its length in metres, whatever the working unit.
TEST(SizeWarning, SaysHowLongTheCharacterIs) {
  scene::Scene scene = scene::load_scene("arm");
  scene.scale = 40.0;
  // Their positions are in metres.
  scene.probes.clear();
  scene.muscles.clear();
  build::Report report;
  const model::Model model = build::build_model(scene, report, with_mesher());
  const double extent = model::extent(model);
  ASSERT_GT(extent, 20.0);
  ASSERT_NE(model.unit, 1.0);
  std::string said;
  for (const build::Warning& warning : report.warnings)
    if (warning.text.find("if its file is not in metres") != std::string::npos) said = warning.text;
  const std::size_t number = said.find("is ");
  ASSERT_NE(number, std::string::npos) << "no warning about its size";
  // The warning prints three digits.
  EXPECT_NEAR(std::stod(said.substr(number + 3)), extent, 0.005 * extent) << said;
}

INSTANTIATE_TEST_SUITE_P(All, MadeScenes, testing::Values("jump", "arm"));

}  // namespace
}  // namespace fascicle::tests
