// Bakes in third-party programs: glTF in Khronos' validator; PC2, MDD and GLB in Blender.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/cli/program.h"
#include "tests/support/assets.h"
#include "tests/support/readers.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

void bake(const std::string& scene, const std::string& folder, const std::string& formats) {
  const Outcome outcome =
      fascicle({"bake", scene, "-o", folder, "--end", "0.1", "--device", "cpu", "--format", formats});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
}

json validated(const fs::path& file) {
  const TemporaryFolder folder;
  const std::string command = "node '" + (node_readers() / "validate_gltf.mjs").string() + "' '" +
                              file.string() + "' > '" + folder / "report.json" + "'";
  EXPECT_EQ(std::system(command.c_str()), 0);
  return json::parse(read_text(folder / "report.json"));
}

// Two scenes: a body without a skeleton, and a walking man whose mesh has seams, a texture and its own rig.
TEST(GltfValidator, FindsNoErrors) {
  FASCICLE_NEEDS_NODE_READERS;
  std::vector<std::string> scenes{"bar-layers-iii"};
  if (fs::exists(asset("CesiumMan.glb")))
    scenes.push_back(asset("CesiumMan.glb").string());
  else
    EXPECT_FALSE(assets_are_required());
  for (const std::string& scene : scenes) {
    const TemporaryFolder folder;
    bake(scene, folder / "bake", "glb");
    std::vector<std::string> files{"surface.glb"};
    if (fs::exists(folder / "bake/character.glb")) files.push_back("character.glb");
    for (const std::string& file : files) {
      const json report = validated(folder / ("bake/" + file));
      EXPECT_EQ(report["issues"]["numErrors"], 0) << scene << ' ' << file << '\n' << report["issues"].dump(1);
      EXPECT_EQ(report["info"]["hasMorphTargets"], file == "surface.glb");
      EXPECT_EQ(report["info"]["hasTextures"], scene != "bar-layers-iii");
      EXPECT_EQ(report["info"]["hasSkins"], scene != "bar-layers-iii");
    }
  }
}

// The control: the validator must report a planted error.
TEST(GltfValidator, SeesAPlantedMistake) {
  FASCICLE_NEEDS_NODE_READERS;
  const TemporaryFolder folder;
  bake("bar-layers-iii", folder / "bake", "glb");
  std::string bytes = read_text(folder / "bake/surface.glb");
  const std::size_t at = bytes.find("\"max\":[");
  ASSERT_NE(at, std::string::npos);
  bytes[at + 7] = bytes[at + 7] == '9' ? '8' : '9';
  write_text(folder / "bake/surface.glb", bytes);
  EXPECT_GE(validated(folder / "bake/surface.glb")["issues"]["numErrors"].get<int>(), 1);
}

TEST(Blender, ShowsTheBakedSurfaceInEveryFrame) {
  FASCICLE_NEEDS_BLENDER;
  const TemporaryFolder folder;
  bake("bar-layers-iii", folder / "bar", "glb,pc2,mdd");
  std::string folders = "'" + folder / "bar" + "'";
  if (fs::exists(asset("CesiumMan.glb"))) {
    bake(asset("CesiumMan.glb").string(), folder / "man", "glb,pc2,mdd");
    folders += " '" + folder / "man" + "'";
  } else {
    EXPECT_FALSE(assets_are_required());
  }
  const std::string command =
      std::string("blender --background --factory-startup --python-exit-code 1 --python '") +
      FASCICLE_SOURCE_DIR + "/tests/readers/measure_blender.py' -- '" + folder / "report.json" + "' " +
      folders + " > '" + folder / "log" + "' 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0) << read_text(folder / "log");
  const json report = json::parse(read_text(folder / "report.json"));
  for (const auto& [bake_folder, formats] : report.items())
    for (const auto& [format, found] : formats.items()) {
      // Files contain floats, and Blender converts axes, skins and blends in floats.
      EXPECT_LE(found["error"].get<double>(), 1e-5) << bake_folder << ' ' << format;
      EXPECT_EQ(found["frames"], 7);
      EXPECT_EQ(found["first"], 0);
      EXPECT_EQ(found["last"], 6);
      EXPECT_EQ(found["fps"], 60.0);
      EXPECT_EQ(found["smooth"], true) << bake_folder << ' ' << format;
      if (!bake_folder.ends_with("/man")) continue;
      // Every format comes with the file's materials and textures.
      EXPECT_EQ(found["materials"], json({"Cesium_Man-effect"})) << format;
      EXPECT_EQ(found["images"], 1) << format;
      EXPECT_EQ(found["uvs"], true) << format;
    }
}

}  // namespace
}  // namespace fascicle::tests
