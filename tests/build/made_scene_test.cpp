// The characters made in code, all the way to a model: TetGen takes their skins, which it refuses when they
// cross themselves, and each layer has its share.
#include <filesystem>

#include <gtest/gtest.h>

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
  const auto& character = std::get<scene::Character>(scene.geometry);
  EXPECT_EQ(model.surface_count(), character.surface.vertices.size());
  ASSERT_EQ(report.layers.size(), 3u);
  for (const build::LayerShare& layer : report.layers)
    EXPECT_GT(layer.volume, 0.02 * report.volume) << layer.name;
  EXPECT_GT(report.pinned_vertices, 0u);
  // What `do bake` may take: a bake of some seconds.
  EXPECT_LT(report.vertices, 12000u);
}

INSTANTIATE_TEST_SUITE_P(All, MadeScenes, testing::Values("jump", "arm"));

}  // namespace
}  // namespace fascicle::tests
