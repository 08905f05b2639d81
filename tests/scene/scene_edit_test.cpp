// Edits of a scene's text that leave the rest of it unchanged.
#include "host/scene/scene_edit.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/base/errors.h"
#include "host/scene/scene.h"
#include "host/scene/scene_file.h"

namespace fascicle::tests {
namespace {

using scene::change_text;
using scene::ChangedText;
using scene::edited_tables;
using scene::EditedKey;
using scene::Json;
using scene::KeyChange;

constexpr const char* sample_scene = R"(# Umlauts count as one column: äöü
[scene]
fps = 60      # äöü

[bar]
size = [0.4, 0.1, 0.1]

# What it is made of.
[layers.fat]
frequency = 20.0   # Hz
damping = 6.0
where = { below = { axis = "y", fraction = 0.5 } }

[layers.muscle]
frequency = 40.0
beta = 1.0
fibre = [1, 0, 0]

[pin.wall]
where = { below = { axis = "x", fraction = 0.0 } }
)";

std::string changed(const std::vector<KeyChange>& changes, const std::string& from = sample_scene) {
  const ChangedText result = change_text(from, "scene.toml", changes);
  EXPECT_TRUE(result.keeps_comments) << result.text;
  return result.text;
}

// `sample_scene` with `part` replaced by `other`.
std::string with(std::string part, const std::string& other, std::string whole = sample_scene) {
  const std::size_t at = whole.find(part);
  EXPECT_NE(at, std::string::npos) << part;
  return whole.replace(at, part.size(), other);
}

const EditedKey* find(const std::vector<scene::EditedTable>& tables, const std::string& path) {
  for (const scene::EditedTable& table : tables)
    for (const EditedKey& key : table.keys)
      if (key.path == path) return &key;
  return nullptr;
}

TEST(SceneEdit, AValueIsReplacedInItsPlace) {
  EXPECT_EQ(changed({{"layers.fat.frequency", 12.5}}), with("frequency = 20.0 ", "frequency = 12.5 "));
  EXPECT_EQ(changed({{"scene.fps", 30}}), with("fps = 60 ", "fps = 30.0 "));
  EXPECT_EQ(changed({{"layers.muscle.fibre", Json{0, 1, 0}}}), with("[1, 0, 0]", "[0.0, 1.0, 0.0]"));
}

TEST(SceneEdit, AValueWithinATableInOneLineIsReplacedThere) {
  EXPECT_EQ(changed({{"layers.fat.where.below.fraction", 0.4}}), with("fraction = 0.5", "fraction = 0.4"));
}

TEST(SceneEdit, ANewKeyFollowsTheOthersOfItsTable) {
  EXPECT_EQ(changed({{"layers.fat.beta", 0.5}}),
            with("fraction = 0.5 } }\n", "fraction = 0.5 } }\nbeta = 0.5\n"));
  EXPECT_EQ(changed({{"motion.settle", 2}}), std::string(sample_scene) + "\n[motion]\nsettle = 2.0\n");
  EXPECT_EQ(changed({{"force.breeze", Json{{"kind", "wind"}, {"vector", {0, 0, 40}}}}}),
            std::string(sample_scene) + "\n[force.breeze]\nkind = \"wind\"\nvector = [0.0, 0.0, 40.0]\n");
}

TEST(SceneEdit, ARivalGivesItsPlace) {
  EXPECT_EQ(changed({{"layers.fat.material", "fat"}}), with("frequency = 20.0 ", "material = \"fat\" "));
  EXPECT_EQ(changed({{"layers.fat.damping_ratio", 0.5}}), with("damping = 6.0", "damping_ratio = 0.5"));
}

TEST(SceneEdit, AKeyIsTakenOutWithItsLine) {
  EXPECT_EQ(changed({{"layers.muscle.beta", std::nullopt}}), with("beta = 1.0\n", ""));
  EXPECT_EQ(changed({{"layers.fat.beta", std::nullopt}}), sample_scene);
}

TEST(SceneEdit, SeveralChangesAreOne) {
  const std::string result = changed({{"layers.fat.frequency", 12.5}, {"layers.fat.youngs_modulus", 3000}});
  EXPECT_EQ(result, with("frequency = 20.0 ", "youngs_modulus = 3000.0 "));
}

TEST(SceneEdit, WhatIsLaidOutOtherwiseIsWrittenAnewAndSaysSo) {
  const std::string dotted =
      "# mine\nscene.fps = 60\nbar.size = [0.4, 0.1, 0.1]\nlayers.fat.alpha = 0.5\n"
      "pin.wall.where = { below = { axis = \"x\", fraction = 0.0 } }\n";
  const ChangedText result =
      change_text(dotted, "scene.toml", std::vector<KeyChange>{{"layers.fat.beta", 0.5}});
  EXPECT_EQ(find(edited_tables(result.text, "scene.toml"), "layers.fat.beta")->value, 0.5);
  EXPECT_EQ(find(edited_tables(result.text, "scene.toml"), "layers.fat.alpha")->value, 0.5);
  EXPECT_EQ(result.keeps_comments, result.text.find("# mine") != std::string::npos);
}

TEST(SceneEdit, WhatIsWrongIsRefusedByItsName) {
  const auto refusal = [](const std::string& path, const Json& value) -> std::string {
    try {
      (void)change_text(sample_scene, "scene.toml", std::vector<KeyChange>{{path, value}});
      return "";
    } catch (const base::SceneError& error) {
      return error.what();
    }
  };
  EXPECT_EQ(refusal("layers.fat.beta", 2), "layers.fat.beta: is 2; must be at most 1");
  EXPECT_NE(refusal("layers.fat.bta", 2).find("beta"), std::string::npos);
  EXPECT_NE(refusal("layers.skin.beta", 1).find("layers"), std::string::npos);
  EXPECT_NE(refusal("layers.fat.beta", "x"), "");
  EXPECT_NE(refusal("layers.fat.beta", Json(nullptr)), "");
  EXPECT_NE(refusal("layers.fat.beta\n[x]", 1), "");
  EXPECT_NE(refusal("", 1), "");
  EXPECT_NE(refusal("..", 1), "");
  // Removing a required table.
  EXPECT_THROW((void)change_text(sample_scene, "scene.toml", std::vector<KeyChange>{{"bar", std::nullopt}}),
               base::SceneError);
}

TEST(SceneEdit, KeysSayWhatHolds) {
  const std::vector<scene::EditedTable> tables = edited_tables(sample_scene, "scene.toml");
  EXPECT_EQ(find(tables, "layers.fat.frequency")->value, 20.0);
  EXPECT_TRUE(find(tables, "layers.fat.frequency")->is_stated);
  EXPECT_EQ(find(tables, "layers.fat.beta")->value, 0.0);
  EXPECT_FALSE(find(tables, "layers.fat.beta")->is_stated);
  EXPECT_TRUE(find(tables, "layers.fat.youngs_modulus")->value.is_null());
  EXPECT_EQ(find(tables, "layers.fat.where.below.fraction")->value, 0.5);
  EXPECT_EQ(find(tables, "solver.rotation")->value, "qcp");
  EXPECT_EQ(find(tables, "character.file"), nullptr);
  EXPECT_EQ(find(tables, "mesh.file"), nullptr);
}

// A session of the studio may be a stranger's, and hold any text.
TEST(SceneEdit, ATextThatNoSceneHasIsRefused) {
  const std::string bar = "[bar]\nsize = [0.4, 0.1, 0.1]\nvertices = [9, 3, 3]\n";
  EXPECT_NO_THROW((void)edited_tables(bar + "[layers.fat]\ndensity = 900.0\n", "scene.toml"));
  for (const char* wrong :
       {"[layers]\nfat = 1\n", "[layers.fat]\ndensity = \"x\"\n", "layers = 1\n", "[bones]\na = 1\n",
        "[character]\na = 1\n", "[force]\na = []\n", "[muscle]\na = 1\n"})
    EXPECT_THROW((void)edited_tables(bar + wrong, "scene.toml"), base::SceneError) << wrong;
}

// Sets every number of every built-in scene to itself, one by one: the text changes only in number format,
// and the scene stays the same.
TEST(SceneEdit, EveryKeyOfTheBuiltInScenesCanBeSet) {
  for (const scene::BuiltinScene& builtin : scene::builtin_scenes()) {
    const std::vector<scene::EditedTable> tables = edited_tables(builtin.text, builtin.name);
    for (const scene::EditedTable& table : tables)
      for (const EditedKey& key : table.keys) {
        if (!key.is_stated || key.key->type == scene::KeyType::tables) continue;
        const ChangedText result =
            change_text(builtin.text, builtin.name, std::vector<KeyChange>{{key.path, key.value}});
        const std::vector<scene::EditedTable> again = edited_tables(result.text, builtin.name);
        ASSERT_EQ(again.size(), tables.size()) << builtin.name << " " << key.path;
        EXPECT_EQ(find(again, key.path)->value, key.value) << builtin.name << " " << key.path;
        EXPECT_TRUE(result.keeps_comments) << builtin.name << " " << key.path;
      }
  }
}

}  // namespace
}  // namespace fascicle::tests
