// Rebuilding a scene with changed keys: cached parts change no bit of the model and no word of the report.
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/bake/identity.h"
#include "host/build/byte_archive.h"
#include "host/build/report_fields.h"
#include "host/pipeline/build_scene.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;

std::string words_of_build(build::Report report) {
  report.seconds = report.fibres.seconds = 0.0;
  report.fill.cage.wrap_seconds = report.fill.cage.fill_seconds = report.fill.cage.cut_seconds = 0.0;
  report.is_kept = report.body_from_cache = false;
  std::string bytes;
  build::ByteWriter write(bytes);
  write(report);
  return bytes;
}

class BuildAgainTest : public testing::Test {
 protected:
  void SetUp() override {
    const testing::TestInfo* info = testing::UnitTest::GetInstance()->current_test_info();
    options_.mesher = fs::path(FASCICLE_BINARY_DIR) / "fascicle-mesher";
    options_.cache = fs::temp_directory_path() / ("fascicle-build-again-" + std::string(info->name()));
    fs::remove_all(options_.cache);
  }
  void TearDown() override { fs::remove_all(options_.cache); }

  // Builds all variants in turn with one cache, each compared with a build without it.
  void expect_same(const std::string& name, const std::vector<std::vector<std::string>>& changes) {
    build::BuildMemory memory;
    for (const std::vector<std::string>& set : changes) {
      scene::SceneOverrides overrides;
      overrides.set = set;
      const scene::Scene scene = scene::load_scene(name, overrides);
      build::Report report;
      const model::Model model = build::build_model(scene, report, options_);
      const pipeline::Built again = pipeline::build_scene_again(scene, options_, memory);
      const std::string what = name + " " + (set.empty() ? "" : set.back());
      EXPECT_EQ(bake::model_hash(again.model), bake::model_hash(model)) << what;
      // Hashes do not cover probes.
      ASSERT_EQ(again.model.probes.size(), model.probes.size());
      for (std::size_t k = 0; k < model.probes.size(); ++k)
        EXPECT_EQ(again.model.probes[k].vertices, model.probes[k].vertices) << what;
      build::Steps steps = build::choose_steps(scene, model, report);
      EXPECT_EQ(words_of_build(again.report), words_of_build(report)) << what;
      EXPECT_EQ(again.steps.substeps, steps.substeps) << what;
    }
  }

  build::BuildOptions options_;
};

// Each change separately, and back again: cached parts must belong to the current scene.
TEST_F(BuildAgainTest, ABarHasTheSameBits) {
  expect_same("bar-layers-iii", {{},
                                 {"layers.fat.alpha=0.2"},
                                 {"layers.fat.beta=0.5"},
                                 {},
                                 {"layers.fat.density=500"},
                                 {"scene.gravity=[0,-3,0]"},
                                 {"bar.jitter=0.2"},
                                 {}});
  expect_same("rod-hang", {{}, {"layers.body.youngs_modulus=3000"}, {"layers.body.frequency=4"}, {}});
}

TEST_F(BuildAgainTest, ACharacterHasTheSameBits) {
  const std::string coarse = "character.resolution=0.12";
  expect_same("crouch", {{coarse},
                         {coarse, "flesh.softness=2"},
                         {coarse, "contact.friction=0.1"},
                         {coarse, "contact.self=false"},
                         {coarse},
                         {coarse, "contact.distance=0.05"},
                         {coarse, "layers.bone.where={ depth = { maximum = 0.4 } }"},
                         {coarse, "layers.fat.density=700"},
                         {coarse, "layers.fat.least_volume=0"},
                         {coarse, "layers.fat.fibre_field=true"},
                         {coarse, "layers.fat.fibre=[1,0,0]"},
                         {coarse, "skeleton.connect=false"},
                         {"character.resolution=0.14"},
                         {coarse}});
}

// Skin that slides shares no regions with the flesh below, so other vertices lie across gaps from it.
TEST_F(BuildAgainTest, SlidingSkinInContactHasTheSameBits) {
  const std::string contact = "contact.self=true";
  expect_same("cheek", {{contact},
                        {contact, "layers.skin.sliding=false"},
                        {contact, "layers.skin.sliding=false", "layers.skin.density=700"},
                        {contact}});
}

// Vertices that sliding would leave without stiffness keep their neighbours, but only if the step is
// implicit: the integrator decides the regions.
TEST_F(BuildAgainTest, SlidingSkinOfEitherIntegratorHasTheSameBits) {
  fs::create_directories(options_.cache);
  const fs::path file = options_.cache / "sliding.toml";
  std::ofstream(file) << "[bar]\nsize = [1.6, 0.6, 0.6]\nvertices = [9, 4, 4]\n[layers.body]\n"
                         "[layers.skin]\nsliding = true\n"
                         "where = { box = { minimum = [-9, 0.1, -9], maximum = [9, 9, 9] } }\n";
  const std::vector<std::string> by_alpha{"layers.body.alpha=0.5", "layers.skin.alpha=0.5"},
      by_modulus{"layers.body.youngs_modulus=5000", "layers.skin.youngs_modulus=5000"};
  expect_same(file.string(), {by_alpha, by_modulus, by_alpha});
}

// A kept model does not depend on gravity, so its report has the warning in either case.
TEST_F(BuildAgainTest, OnlyGravityMakesBodiesFall) {
  build::BuildMemory memory;
  scene::Scene scene;
  scene.geometry = scene::Bar{.vertices = {4, 3, 3}};
  scene.layers.resize(1);
  for (const double down : {-9.81, 0.0, -1.0}) {
    scene.gravity = {0, down, 0};
    for (const pipeline::Built& built :
         {pipeline::build_scene(scene, options_, {}), pipeline::build_scene_again(scene, options_, memory)}) {
      std::size_t told = 0;
      for (const build::Warning& warning : built.report.warnings)
        told += warning.text.find("fall for ever") != std::string::npos;
      EXPECT_EQ(told, down < 0.0 ? 1u : 0u) << down;
    }
  }
}

TEST(BodyKey, TellsBodiesApartAndNothingElse) {
  const auto key = [](const std::vector<std::string>& set) {
    scene::SceneOverrides overrides;
    overrides.set = set;
    return build::body_key(scene::load_scene("arm", overrides)).value();
  };
  const std::string plain = key({});
  for (const char* same : {"flesh.softness=2", "scene.gravity=[0,0,0]", "scene.end=0.5", "motion.settle=1",
                           "contact.self=true", "scene.fps=30"})
    EXPECT_EQ(key({same}), plain) << same;
  for (const char* other : {"character.resolution=0.02", "character.made=arm-bent", "body.cage=wrap",
                            "skeleton.least_share=0.02", "skeleton.connect=false"})
    EXPECT_NE(key({other}), plain) << other;
}

}  // namespace
}  // namespace fascicle::tests
