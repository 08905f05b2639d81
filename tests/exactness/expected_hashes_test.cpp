// The results of every built-in scene and every character of ../shared/assets, as stored hashes: a change
// that should not affect results must not change any of them.
//
// expected_hashes.txt has a line per scene: its name, its number of frames, and the hashes of positions,
// velocities and surface that frame_hashes prints for the last frame. A change meant to change results
// rewrites the file:
//   FASCICLE_WRITE_HASHES=1 build/release/test_exactness --gtest_filter='*/ExpectedHashes*'
// CI compares the built-in scenes and some of the characters, `./do soak` all.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/scene/scene.h"
#include "tests/exactness/process.h"
#include "tests/support/assets.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;

const fs::path table_file = fs::path(FASCICLE_SOURCE_DIR) / "tests/exactness/expected_hashes.txt";
const std::string asset_prefix = "assets/";

struct Row {
  std::string name;  // a built-in scene, or assets/FILE
  int frames = 0;
  std::string hashes;
};

std::vector<Row> table() {
  std::vector<Row> rows;
  std::ifstream in(table_file);
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line.front() == '#') continue;
    std::istringstream words(line);
    Row row;
    words >> row.name >> row.frames >> std::ws;
    std::getline(words, row.hashes);
    rows.push_back(row);
  }
  return rows;
}

bool writes_table() {
  return std::getenv("FASCICLE_WRITE_HASHES") != nullptr;
}

bool is_asset(const std::string& name) {
  return name.rfind(asset_prefix, 0) == 0;
}

std::string hashes_of(const Row& row) {
  const std::string scene =
      is_asset(row.name) ? asset(row.name.substr(asset_prefix.size())).string() : row.name;
  const Output output = run(std::string(FASCICLE_BINARY_DIR) + "/frame_hashes '" + scene + "' " +
                            std::to_string(row.frames) + " cpu:0");
  EXPECT_EQ(output.status, 0) << row.name << ": " << output.text;
  std::istringstream lines(output.text);
  std::string last;
  for (std::string line; std::getline(lines, line);)
    if (line.rfind(std::to_string(row.frames) + " ", 0) == 0) last = line.substr(line.find(' ') + 1);
  return last;
}

// Each of these takes 10 s of CPU time or more, and the tests of flesh, build and pipeline build and watch
// such bodies too: people, animals, bodies with a cage.
bool is_for_soak(const Row& row) {
  static const std::set<std::string> names{"assets/animals_pack_Bull.glb",
                                           "assets/animals_pack_Fox.glb",
                                           "assets/dinosaurs_pack_Trex.glb",
                                           "assets/easy_enemies_Frog.glb",
                                           "assets/mh_fat.glb",
                                           "assets/mh_fat_selfint.glb",
                                           "assets/mh_muscle.glb",
                                           "assets/modular_women_Formal.glb"};
  return names.contains(row.name);
}

std::vector<Row> rows_that(bool are_for_soak) {
  std::vector<Row> rows = table();
  std::erase_if(rows, [&](const Row& row) { return is_for_soak(row) != are_for_soak; });
  return rows;
}

class ExpectedHashes : public testing::TestWithParam<Row> {};
class ExpectedHashesSoak : public ExpectedHashes {};

void expect_hashes(const Row& row) {
  if (is_asset(row.name)) FASCICLE_NEEDS_ASSET(asset(row.name.substr(asset_prefix.size())));
  const std::string found = hashes_of(row);
  if (!writes_table()) {
    EXPECT_EQ(found, row.hashes) << row.name << ", frame " << row.frames
                                 << ": if this change is meant to change results, rewrite " << table_file
                                 << " as described at the top of this test, and mention it in CHANGELOG.md";
    return;
  }
  std::ifstream in(table_file);
  std::ostringstream text;
  for (std::string line; std::getline(in, line);)
    text << (line.rfind(row.name + " ", 0) == 0 ? row.name + " " + std::to_string(row.frames) + " " + found
                                                : line)
         << "\n";
  in.close();
  std::ofstream(table_file) << text.str();
}

std::string test_name(const testing::TestParamInfo<Row>& info) {
  std::string name;
  for (const char c : info.param.name)
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) name += c;
  return name;
}
TEST_P(ExpectedHashes, AreWhatTheyWere) {
  expect_hashes(GetParam());
}
TEST_P(ExpectedHashesSoak, AreWhatTheyWere) {
  expect_hashes(GetParam());
}
INSTANTIATE_TEST_SUITE_P(All, ExpectedHashes, testing::ValuesIn(rows_that(false)), test_name);
INSTANTIATE_TEST_SUITE_P(Slow, ExpectedHashesSoak, testing::ValuesIn(rows_that(true)), test_name);

// A scene without a row would not be compared.
TEST(ExpectedHashesTable, HoldsEverySceneAndEveryCharacter) {
  std::set<std::string> rows;
  for (const Row& row : table()) rows.insert(row.name);
  for (const scene::BuiltinScene& scene : scene::builtin_scenes())
    EXPECT_TRUE(rows.count(scene.name)) << scene.name;
  const fs::path assets = asset("");
  if (!fs::exists(assets)) return;
  for (const auto& entry : fs::directory_iterator(assets))
    if (entry.path().extension() == ".glb") {
      EXPECT_TRUE(rows.count(asset_prefix + entry.path().filename().string())) << entry.path();
    }
}

// The control: different scenes have different hashes.
TEST(ExpectedHashesTable, TellsScenesApart) {
  std::map<std::string, std::string> name_of;
  for (const Row& row : table()) {
    const auto [other, is_new] = name_of.try_emplace(row.hashes, row.name);
    EXPECT_TRUE(is_new) << row.name << " and " << other->second;
  }
}

}  // namespace
}  // namespace fascicle::tests
