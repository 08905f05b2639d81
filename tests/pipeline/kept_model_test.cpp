// Cached models: their keys, and that they equal what would be built.
#include "host/pipeline/kept_model.h"

#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "host/bake/identity.h"
#include "host/build/byte_archive.h"
#include "host/build/cache.h"
#include "host/build/report_fields.h"
#include "host/made/made_character.h"
#include "host/pipeline/build_scene.h"
#include "host/scene/paint_file.h"
#include "host/scene/scene_table.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;
using pipeline::find_kept_model;
using pipeline::keep_model;
using pipeline::kept_model_key;

class KeptModelTest : public testing::Test {
 protected:
  void SetUp() override {
    const testing::TestInfo* info = testing::UnitTest::GetInstance()->current_test_info();
    options_.mesher = fs::path(FASCICLE_BINARY_DIR) / "fascicle-mesher";
    options_.cache = fs::temp_directory_path() / ("fascicle-kept-model-" + std::string(info->name()));
    fs::remove_all(options_.cache);
  }
  void TearDown() override { fs::remove_all(options_.cache); }

  scene::Scene scene_of(const std::string& name, const std::vector<std::string>& set) const {
    scene::SceneOverrides overrides;
    overrides.set = set;
    return scene::load_scene(name, overrides);
  }
  std::string key_of(const std::string& name, const std::vector<std::string>& set = {}) const {
    return kept_model_key(scene_of(name, set), options_).value();
  }

  build::BuildOptions options_;
};

std::string bytes_of(const build::Report& report) {
  std::string bytes;
  build::ByteWriter write(bytes);
  write(report);
  return bytes;
}

// The report of a build, without what depends on when it ran.
std::string words_of(build::Report report) {
  report.seconds = report.fibres.seconds = 0.0;
  report.fill.cage.wrap_seconds = report.fill.cage.fill_seconds = report.fill.cage.cut_seconds = 0.0;
  report.is_kept = report.body_from_cache = false;
  return bytes_of(report);
}

// The generated bear, coarser than in its scenes.
const std::vector<std::string> coarse_bear{"character.resolution=0.12"};

TEST_F(KeptModelTest, IsWhatWouldBeBuilt) {
  const scene::Scene scene = scene_of("crouch", coarse_bear);
  build::BuildOptions without_cache = options_;
  without_cache.cache.clear();
  const pipeline::Built built = pipeline::build_scene(scene, without_cache, {});
  ASSERT_FALSE(built.report.is_kept);
  build::Report report;
  keep_model(kept_model_key(scene, options_).value(), build::build_model(scene, report, options_), report,
             options_);
  const pipeline::Built kept = pipeline::build_scene(scene, options_, {});
  ASSERT_TRUE(kept.report.is_kept);
  EXPECT_EQ(bake::model_hash(kept.model), bake::model_hash(built.model));
  EXPECT_EQ(words_of(kept.report), words_of(built.report));
  EXPECT_EQ(kept.steps.substeps, built.steps.substeps);
  EXPECT_EQ(kept.steps.iterations, built.steps.iterations);
  EXPECT_EQ(kept.steps.reason, built.steps.reason);
}

// Settings that are not part of the key do not change the model.
TEST_F(KeptModelTest, IsTheSameForAllClipsRatesAndTimes) {
  const std::vector<std::vector<std::string>> others{
      {"character.clip=\"bump\""},
      {"scene.end=0.5", "scene.start=0.1"},
      {"scene.fps=24"},
      {"scene.gravity=[0,0,-3]"},
      {"motion.preroll=0.5", "motion.rest=\"weightless\""},
      {"motion.interpolation=\"smooth\""},
      {"motion.interpolation=\"smooth\"", "motion.hold=0.0", "motion.loop=3"},
      {"character.clip=\"bump\"", "motion.interpolation=\"smooth\"", "motion.hold=0.0",
       "motion.seamless=true"}};
  const scene::Scene first = scene_of("crouch", coarse_bear);
  const std::string key = kept_model_key(first, options_).value();
  build::BuildOptions without_cache = options_;
  without_cache.cache.clear();
  build::Report report;
  const model::Model model = build::build_model(first, report, without_cache);
  for (const std::vector<std::string>& set : others) {
    std::vector<std::string> sets = coarse_bear;
    sets.insert(sets.end(), set.begin(), set.end());
    const scene::Scene other = scene_of("crouch", sets);
    EXPECT_EQ(kept_model_key(other, options_), key) << set.front() << " and " << set.size() - 1 << " more";
    build::Report found;
    EXPECT_EQ(bake::model_hash(build::build_model(other, found, without_cache)), bake::model_hash(model))
        << set.front() << " and " << set.size() - 1 << " more";
    EXPECT_EQ(words_of(found), words_of(report)) << set.front() << " and " << set.size() - 1 << " more";
  }
}

// Each of these changes the model, or might.
TEST_F(KeptModelTest, AnotherModelHasAnotherKey) {
  const std::vector<std::string> sets{"layers.fat.youngs_modulus=60000.0",
                                      "layers.fat.damping=11.0",
                                      "layers.muscle.beta=0.5",
                                      "layers.bone.where.depth.maximum=0.31",
                                      "character.resolution=0.05",
                                      "body.cage_detail=90",
                                      "contact.self=false",
                                      "contact.friction=0.4",
                                      "contact.ignore=[[\"head\"]]",
                                      "solver.substeps=8",
                                      "skeleton.least_share=0.02",
                                      "probe.belly.where={sphere={center=[0.0,0.8,0.3],radius=0.2}}",
                                      "flesh.softness=1.5"};
  std::map<std::string, std::string> seen{{key_of("crouch"), "as it is"}};
  for (const std::string& set : sets) {
    const auto [place, is_new] = seen.emplace(key_of("crouch", {set}), set);
    EXPECT_TRUE(is_new) << set << " has the key of " << place->second;
  }
}

// The key depends on the content of a file, not on its name.
TEST_F(KeptModelTest, AnotherContentHasAnotherKey) {
  fs::create_directories(options_.cache);
  const fs::path mesh = options_.cache / "tetrahedron.obj";
  const auto key_with_top_at = [&](const std::string& height) {
    std::ofstream(mesh) << "v 0 0 0\nv 1 0 0\nv 0 0 1\nv 0 " << height
                        << " 0\nf 1 2 3\nf 1 4 2\nf 2 4 3\nf 1 3 4\n";
    return key_of(mesh.string());
  };
  const std::string low = key_with_top_at("1.0");
  EXPECT_NE(key_with_top_at("1.5"), low);
  EXPECT_EQ(key_with_top_at("1.0"), low);
}

// Paint files with the same name and different content make different bodies, and each is found as it would
// be built.
TEST_F(KeptModelTest, AnotherPaintIsAnotherModel) {
  fs::create_directories(options_.cache);
  const fs::path file = options_.cache / "bear.paint.json";
  const rig::Character bear = made::make_character("bear");
  const std::vector<std::string> set{"character.resolution=0.12", "character.paint=" + file.string()};
  // Paints one side of the bear with this value.
  const auto scene_painted = [&](const char* name, float value, bool left) {
    rig::Paint paint{rig::surface_hash(bear.surface), bear.surface.vertices.size(), {{name, {}, {}}}};
    for (std::uint32_t v = 0; v < bear.surface.vertices.size(); ++v) {
      if ((bear.surface.vertices[v][0] > 0.05) != left) continue;
      paint.attributes[0].vertex.push_back(v);
      paint.attributes[0].value.push_back(value);
    }
    std::ofstream(file) << scene::paint_text(paint);
    return scene_of("crouch", set);
  };
  build::BuildOptions without_cache = options_;
  without_cache.cache.clear();
  std::set<std::uint64_t> seen;
  std::set<std::string> keys{key_of("crouch", {"character.resolution=0.12"})};
  build::BuildMemory memory;
  for (const bool is_again : {false, true})
    for (const auto& [name, value, left] :
         {std::tuple("_LAYER", 1.0f, true), {"_LAYER", 1.0f, false}, {"_RIGID", 1.0f, true}}) {
      const scene::Scene scene = scene_painted(name, value, left);
      build::Report report;
      const std::uint64_t hash = bake::model_hash(build::build_model(scene, report, without_cache));
      EXPECT_EQ(bake::model_hash(pipeline::build_scene(scene, options_, {}).model), hash) << name << value;
      EXPECT_EQ(bake::model_hash(pipeline::build_scene_again(scene, options_, memory).model), hash)
          << name << value;
      EXPECT_EQ(seen.insert(hash).second, !is_again) << "the control: paint changes the model";
      EXPECT_EQ(keys.insert(kept_model_key(scene, options_).value()).second, !is_again);
    }
}

// The key includes the clip if a muscle can depend on it or several characters are joined.
TEST_F(KeptModelTest, TheClipCountsWhereTheModelMaySeeIt) {
  EXPECT_NE(key_of("arm"), key_of("arm", {"character.clip=0"}));
  EXPECT_NE(key_of("two-bears"), key_of("two-bears", {"character.left.clip=\"jump\""}));
}

TEST_F(KeptModelTest, NothingIsKeptWithoutACacheOrOfAGeometryWithoutAName) {
  scene::Scene scene = scene_of("bar-hang-none", {});
  EXPECT_TRUE(kept_model_key(scene, options_));
  scene.input_hashes.clear();
  EXPECT_FALSE(kept_model_key(scene, options_));
  scene = scene_of("bar-hang-none", {});
  scene.input_hashes.emplace_back("man.fbx", "00");
  EXPECT_FALSE(kept_model_key(scene, options_));
  scene = scene_of("bar-hang-none", {});
  options_.cache.clear();
  EXPECT_FALSE(kept_model_key(scene, options_));
}

// Bytes with a correct checksum may still be foreign, truncated or malicious: they are rejected, at any
// length.
TEST_F(KeptModelTest, IsNotBelievedWhereItIsNotWhole) {
  const scene::Scene scene = scene_of("bar-hang-none", {});
  const std::string key = kept_model_key(scene, options_).value();
  build::Report report;
  const model::Model model = build::build_model(scene, report, options_);
  report.warnings.push_back({"a word", {1, 2}, true});
  report.layers.front().youngs_modulus = 2.0;
  keep_model(key, model, report, options_);
  const auto kept = find_kept_model(key, options_);
  ASSERT_TRUE(kept);
  EXPECT_EQ(bake::model_hash(kept->model), bake::model_hash(model));
  EXPECT_EQ(bytes_of(kept->report), bytes_of(report));

  const build::Cache cache(options_.cache);
  const std::string whole = cache.find(key).value();
  for (std::size_t size = 0; size < whole.size(); size += 1 + whole.size() / 97) {
    cache.put(key, std::string_view(whole).substr(0, size));
    EXPECT_FALSE(find_kept_model(key, options_)) << size << " of " << whole.size() << " bytes";
  }
  build::Report crooked = report;
  crooked.fill.cage.ends.vertex.push_back(3);
  keep_model(key, model, crooked, options_);
  EXPECT_FALSE(find_kept_model(key, options_)) << "an end without a joint";
  cache.put(key, whole + "x");
  EXPECT_FALSE(find_kept_model(key, options_));
  for (std::size_t at = 0; at < whole.size(); at += 1 + whole.size() / 61) {
    std::string changed = whole;
    changed[at] = static_cast<char>(changed[at] ^ 0x40);
    cache.put(key, changed);
    // A changed report may still be valid; the model has its own checksum.
    const auto found = find_kept_model(key, options_);
    if (!found) continue;
    EXPECT_EQ(bake::model_hash(found->model), bake::model_hash(model)) << at;
  }
}

}  // namespace
}  // namespace fascicle::tests
