// Products of the key tables: the page docs/scene.md, and the manifest's copy of a scene.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "host/scene/scene.h"
#include "host/scene/scene_json.h"
#include "host/scene/scene_table.h"

namespace fascicle::tests {
namespace {

TEST(SceneReference, ThePageIsWhatTheProgramPrints) {
  std::ifstream file(std::filesystem::path(FASCICLE_SOURCE_DIR) / "docs/scene.md");
  const std::string page((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  EXPECT_TRUE(page == scene::scene_reference()) << "docs/scene.md is out of date: run ./do scene-reference";
}

TEST(SceneReference, NamesEveryKeyInShortLines) {
  const std::string page = scene::scene_reference();
  std::vector<const scene::Table*> left{&scene::scene_table()};
  std::set<const scene::Table*> seen;
  while (!left.empty()) {
    const scene::Table* table = left.back();
    left.pop_back();
    if (!seen.insert(table).second) continue;
    for (const scene::Key& key : table->keys) {
      const bool is_root = table == &scene::scene_table();
      EXPECT_NE(page.find(is_root ? "`[" + key.name : "- `" + key.name + "`: "), std::string::npos)
          << key.name;
      for (const scene::Table* inner : {key.table, key.named})
        if (inner != nullptr) left.push_back(inner);
    }
  }
  EXPECT_GT(seen.size(), 20u);
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 120u) << line;
}

// Keys of a table that are missing from the manifest's copy.
std::vector<std::string> missing(const std::string& table, const scene::Json& copy) {
  std::vector<std::string> names;
  for (const std::string& name : scene::key_names(*scene::find_key(scene::scene_table(), table)->table))
    if (!copy.contains(name)) names.push_back(name);
  return names;
}

TEST(SceneReference, TheManifestHasEveryKey) {
  scene::Layer layer;
  layer.sliding = true;
  layer.volume = layer.least_volume = 0.5;
  layer.contact = false;
  const std::vector<std::string> none;
  EXPECT_EQ(missing("layers", json_of(layer)), none);
  EXPECT_EQ(missing("muscle", json_of(scene::Muscle{})), none);
  EXPECT_EQ(missing("motion", json_of(scene::Motion{})), none);
  EXPECT_EQ(missing("flesh", json_of(scene::FleshSettings{})), none);
  EXPECT_EQ(missing("solver", json_of(scene::SolverSettings{})), none);
  EXPECT_EQ(missing("skeleton", json_of(scene::SkeletonSettings{})), none);
  scene::ContactSettings contact;
  contact.distance = 0.5;
  EXPECT_EQ(missing("contact", json_of(contact)), none);
  EXPECT_EQ(missing("force", json_of(scene::Force{})), none);
  EXPECT_EQ(missing("fibres", json_of(scene::FibreCurve{})), none);
  EXPECT_EQ(missing("bones", json_of(scene::BoneSegment{})), none);
  EXPECT_EQ(missing("bar", json_of(scene::Bar{})), none);
  // The description is only in the scene's text.
  EXPECT_EQ(missing("scene", json_of(scene::Scene{})), std::vector<std::string>{"description"});
  // Each table of settings is in the copy under its own name; these four define the scene itself.
  const scene::Json copy = json_of(scene::Scene{});
  const std::set<std::string> others{"scene", "bar", "mesh", "character"};
  for (const scene::Key& key : scene::scene_table().keys) {
    const bool is_asked = key.type == scene::KeyType::table && !others.contains(key.name);
    EXPECT_TRUE(!is_asked || copy.contains(key.name)) << key.name;
  }
  // The control: a key that most layers lack is not in the copy of such a layer.
  EXPECT_EQ(missing("layers", json_of(scene::Layer{})),
            (std::vector<std::string>{"sliding", "volume", "least_volume", "contact"}));
}

// The words of a key map to the values of its enumeration in order.
TEST(SceneReference, WordsAreTheValues) {
  scene::Motion motion;
  motion.rest = scene::Rest::weightless;
  motion.interpolation = scene::KeyInterpolation::as_authored;
  EXPECT_EQ(json_of(motion)["rest"], "weightless");
  EXPECT_EQ(json_of(motion)["interpolation"], "as-authored");
  scene::Force force;
  force.kind = scene::ForceKind::wind;
  EXPECT_EQ(json_of(force)["kind"], "wind");
  scene::VolumeShare share;
  share.by_distance = true;
  EXPECT_EQ(json_of(share)["by"], "distance");
  EXPECT_EQ(json_of(scene::Where{scene::HalfSpace{scene::Axis::z, false, true, 0.25}}).dump(),
            R"([{"above":{"axis":"z","fraction":0.25}}])");
}

}  // namespace
}  // namespace fascicle::tests
