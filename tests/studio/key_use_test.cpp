// Keys that the studio does not offer are those that the scene reader would refuse.
#include "host/studio/key_use.h"

#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/base/errors.h"
#include "host/scene/scene_edit.h"
#include "host/scene/scene_file.h"

namespace fascicle::tests {
namespace {

using scene::Json;

const std::string bare_bar =
    "[scene]\nend = 0.1\n[bar]\nsize = [0.4, 0.1, 0.1]\nvertices = [5, 3, 3]\n"
    "[pin.wall]\nwhere = { below = { axis = \"x\", fraction = 0.0 } }\n";
const std::string bone_end =
    "[layers.bone]\nkinematic = true\nwhere = { above = { axis = \"x\", fraction = 0.9 } }\n";

// A valid value for each key.
const std::map<std::string, Json> values_in_use{
    {"alpha", 0.5},         {"youngs_modulus", 2e4}, {"frequency", 5.0},   {"material", "fat"},
    {"damping_ratio", 0.5}, {"least_volume", 0.2},   {"iterations", 4},    {"quality", "draft"},
    {"alpha_outer", 0.3},   {"sliding", true},       {"viscosity", 0.001},
};

bool can_be_set(const std::string& text, const std::string& path, const Json& value) {
  const scene::KeyChange change{path, value};
  try {
    const std::string changed = scene::change_text(text, "bar.toml", std::span(&change, 1)).text;
    (void)scene::parse_scene({"bar", "bar.toml", changed, {}}, {});
    return true;
  } catch (const base::SceneError&) {
    return false;
  }
}

TEST(KeyUse, WhatIsHiddenIsRefusedAndWhatIsShownIsTaken) {
  std::set<std::string> hidden, shown;
  for (const std::string& text :
       {bare_bar + "[layers.body]\nalpha = 0.5\n", bare_bar + "[layers.body]\nyoungs_modulus = 2e4\n",
        bare_bar + "[layers.body]\nalpha = 0.5\n[solver]\nintegrator = \"explicit\"\n",
        bare_bar +
            "[layers.body]\nmaterial = \"fat\"\n[solver]\nintegrator = \"implicit\"\nsubsteps = \"auto\"\n",
        bare_bar +
            "[layers.body]\nfrequency = 6.0\n[layers.end]\nyoungs_modulus = 1e4\nwhere = { above = { axis = "
            "\"x\", fraction = 0.5 } }\n",
        bare_bar + "[layers.body]\nalpha = 0.5\n[layers.end]\nalpha = 0.2\nwhere = { above = { axis = \"x\", "
                   "fraction = "
                   "0.5 } }\n",
        bare_bar + "[layers.body]\nfrequency = 6.0\n" + bone_end}) {
    ASSERT_NO_THROW(scene::parse_scene({"bar", "bar.toml", text, {}}, {})) << text;
    const std::vector<scene::EditedTable> tables = scene::edited_tables(text, "bar.toml");
    const studio::KeyUse use(tables);
    for (const scene::EditedTable& table : tables)
      for (const scene::EditedKey& key : table.keys) {
        const auto value = values_in_use.find(key.key->name);
        if (value == values_in_use.end() || (table.path != "solver" && !table.path.starts_with("layers.")) ||
            key.is_stated)
          continue;
        const std::string why = use.why_unused(table, key);
        EXPECT_EQ(why.empty(), can_be_set(text, key.path, value->second)) << key.path << " in\n"
                                                                          << text << why;
        (why.empty() ? shown : hidden).insert(key.key->name);
      }
  }
  EXPECT_EQ(hidden.size(), values_in_use.size()) << "the control: each is hidden somewhere";
  EXPECT_GE(shown.size(), values_in_use.size() - 1);
}

}  // namespace
}  // namespace fascicle::tests
