// Paint written into a glTF file: read back, it is the same character with the paint.
#include "host/formats/painted_gltf.h"

#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/gltf/gltf.h"
#include "host/scene/paint_file.h"
#include "tests/gltf/gltf_builder.h"

namespace fascicle::tests {
namespace {

using nlohmann::json;

// Directions are rotated into the file's space, rounded to single precision, and rotated back.
constexpr double turned = 1e-6;

std::map<std::string, std::vector<double>> painted_on(const rig::Character& character) {
  std::map<std::string, std::vector<double>> values;
  for (const rig::PaintedAttribute& attribute : character.painted) values[attribute.name] = attribute.values;
  return values;
}

void expect_same(const GltfBuilder& builder) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.write("column.glb", builder.glb());
  rig::Character character = gltf::read_gltf(file);
  const auto count = static_cast<std::uint32_t>(character.surface.vertices.size());
  rig::Paint paint;
  paint.surface = rig::surface_hash(character.surface);
  paint.vertices = count;
  paint.attributes = {{"_RIGID", {2, count - 1}, {1.0f, 0.25f}},
                      {"_LAYER", {0, 5, 9}, {3.0f, 2.0f, 1.0f}},
                      {"_STIFFNESS", {1, count - 2}, {0.1f, 0.7f}},
                      {"_FIBER", {3, count - 3}, {0.6f, 0.8f, 0.0f, 0.0f, -0.28f, 0.96f}}};
  rig::lay_over(scene::parse_paint(scene::paint_text(paint), "paint", character.surface), character);
  std::vector<std::string> missing;
  const std::string bytes = formats::painted_glb(file, character, paint, missing);
  EXPECT_TRUE(missing.empty());
  const rig::Character again = gltf::read_gltf(folder.write("painted.glb", bytes));
  EXPECT_EQ(rig::surface_hash(again.surface), paint.surface) << "the paint also fits the painted file";
  EXPECT_EQ(again.weights, character.weights);
  EXPECT_EQ(again.clips.size(), character.clips.size());
  auto before = painted_on(character), after = painted_on(again);
  for (const char* name : {"_RIGID", "_LAYER", "_STIFFNESS"}) EXPECT_EQ(after[name], before[name]) << name;
  ASSERT_EQ(after["_FIBER"].size(), before["_FIBER"].size());
  double length = 0.0;
  for (std::size_t k = 0; k < before["_FIBER"].size(); ++k) {
    EXPECT_NEAR(after["_FIBER"][k], before["_FIBER"][k], turned) << k;
    length += std::abs(before["_FIBER"][k]);
  }
  EXPECT_GT(length, 1.0) << "the control: there are fibres";
}

// The column's file has Z up.
TEST(PaintedGltf, ReadsAsThePaint) {
  expect_same(column());
}

TEST(PaintedGltf, WithBlendShapes) {
  expect_same(column_with_shapes());
}

// Two nodes with one mesh can be painted differently.
TEST(PaintedGltf, AMeshOfTwoNodesBecomesTwo) {
  GltfBuilder twice = column();
  json& nodes = twice.document["nodes"];
  nodes.push_back(json(nodes[3]));
  for (json& scene : twice.document["scenes"]) scene["nodes"].push_back(nodes.size() - 1);
  const TemporaryFolder folder;
  ASSERT_EQ(gltf::read_gltf(folder.write("twice.glb", twice.glb())).surface.vertices.size(), 24u);
  expect_same(twice);
}

}  // namespace
}  // namespace fascicle::tests
