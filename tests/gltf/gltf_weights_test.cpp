// Weights that viewers would misread are repaired in the document that is written out again.
#include "host/gltf/gltf_weights.h"

#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "host/gltf/gltf.h"
#include "host/gltf/gltf_rig.h"
#include "host/rig/pose.h"
#include "tests/gltf/gltf_builder.h"
#include "tests/gltf/gltf_viewer.h"

namespace fascicle::tests {
namespace {

using nlohmann::json;

constexpr std::size_t vertices = 12;

// The column with other weights, four a vertex: of the lower joint, of the upper one, and two of none.
GltfBuilder column_of(const std::vector<float>& weights) {
  GltfBuilder b = column();
  b.document["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = b.add("VEC4", weights);
  return b;
}

std::vector<float> weights_with(const std::function<void(std::size_t vertex, float* weights)>& change) {
  std::vector<float> weights;
  for (std::size_t i = 0; i < vertices; ++i) {
    const float upper = 0.5f * static_cast<float>(i / 4);
    weights.insert(weights.end(), {1.0f - upper, upper, 0.0f, 0.0f});
    change(i, weights.data() + 4 * i);
  }
  return weights;
}

gltf::GltfDocument packed(const GltfBuilder& builder) {
  const TemporaryFolder folder;
  std::vector<std::string> missing;
  return gltf::pack_gltf(folder.write("a.glb", builder.glb()), missing);
}

GltfViewer viewer_of(const gltf::GltfDocument& document) {
  return {document.json, {document.binary.begin(), document.binary.end()}};
}

void expect_same_pictures(const GltfViewer& shown, const GltfViewer& wanted) {
  for (const double time : {0.0, 0.3, 1.0}) {
    const std::vector<Eigen::Vector3d> a = shown.shown(0, time), b = wanted.shown(0, time);
    ASSERT_EQ(a.size(), b.size());
    // The document's weights are floats, and the column is 2 m high.
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_LT((a[i] - b[i]).norm(), 1e-6) << i << " at " << time;
  }
}

const json& attributes_of(const json& document) {
  return document["meshes"][0]["primitives"][0]["attributes"];
}

// Some viewers divide by the sum, as ours does here, and others do not.
void expect_sums_of_one(const gltf::GltfDocument& document) {
  std::vector<double> sums(vertices, 0.0);
  for (const auto& [name, number] : attributes_of(document.json).items()) {
    if (!name.starts_with("WEIGHTS_")) continue;
    const json& accessor = document.json["accessors"][number.get<std::size_t>()];
    ASSERT_EQ(accessor["componentType"], 5126);
    const json& view = document.json["bufferViews"][accessor["bufferView"].get<std::size_t>()];
    std::vector<float> weights(4 * vertices);
    std::memcpy(weights.data(), document.binary.data() + view["byteOffset"].get<std::size_t>(),
                weights.size() * sizeof(float));
    for (std::size_t k = 0; k < weights.size(); ++k) sums[k / 4] += double{weights[k]};
  }
  for (const double sum : sums) EXPECT_NEAR(sum, 1.0, 1e-6);  // of floats
}

TEST(RepairWeights, LeavesGoodWeightsAlone) {
  const GltfBuilder b = column_of(weights_with([](std::size_t, float* w) { w[0] += 0.0005f; }));
  const gltf::GltfDocument document = packed(b);
  for (const char* list : {"accessors", "bufferViews", "meshes"})
    EXPECT_EQ(document.json[list].size(), b.document[list].size()) << list;
  EXPECT_EQ(attributes_of(document.json), attributes_of(b.document));
  EXPECT_EQ(document.binary, std::string(b.bytes.begin(), b.bytes.end()));
}

TEST(RepairWeights, MakesTheirSumOne) {
  const GltfBuilder halves = column_of(weights_with([](std::size_t i, float* w) {
    for (int k = 0; k < 4; ++k) w[k] *= i % 2 == 0 ? 0.5f : 3.0f;
  }));
  const GltfViewer wanted(column_of(weights_with([](std::size_t, float*) {})));
  expect_same_pictures(viewer_of(packed(halves)), wanted);
  expect_sums_of_one(packed(halves));
}

TEST(RepairWeights, GivesThemWhereThereAreNone) {
  // A corner of the top. Of the vertices it is connected to, number 4 comes first, which follows both joints
  // alike.
  const GltfBuilder without = column_of(weights_with([](std::size_t i, float* w) {
    if (i == 9) w[0] = w[1] = 0.0f;
  }));
  const GltfViewer wanted(column_of(weights_with([](std::size_t i, float* w) {
    if (i == 9) w[0] = w[1] = 0.5f;
  })));
  const GltfViewer viewer = viewer_of(packed(without));
  expect_same_pictures(viewer, wanted);
  expect_sums_of_one(packed(without));

  // What the bake simulates, and what every format writes, is the same skin.
  const TemporaryFolder folder;
  const rig::Character character = gltf::read_gltf(folder.write("a.glb", without.glb()));
  const rig::Clip* clip = rig::find_clip(character, "bend");
  ASSERT_NE(clip, nullptr);
  const std::vector<Eigen::Matrix4d> joints = rig::joint_transforms_at(character, clip, 1.0);
  Eigen::Vector3d skinned = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < 8; ++k) {
    const std::uint32_t j = character.joints[9][k];
    const Eigen::Matrix4d map = joints[j] * character.skeleton[j].inverse_bind;
    skinned += character.weights[9][k] * (map * character.surface.vertices[9].homogeneous()).head<3>();
  }
  EXPECT_LT((viewer.shown(0, 1.0)[9] - skinned).norm(), 1e-6);
}

TEST(RepairWeights, TakesAllSetsOfJoints) {
  GltfBuilder b = column_of(weights_with([](std::size_t, float* w) { w[0] *= 0.25f, w[1] *= 0.25f; }));
  json& attributes = b.document["meshes"][0]["primitives"][0]["attributes"];
  attributes["JOINTS_1"] = attributes["JOINTS_0"];
  attributes["WEIGHTS_1"] = attributes["WEIGHTS_0"];
  const gltf::GltfDocument document = packed(b);
  EXPECT_NE(attributes_of(document.json)["WEIGHTS_1"], attributes["WEIGHTS_1"]);
  EXPECT_NE(attributes_of(document.json)["WEIGHTS_1"], attributes_of(document.json)["WEIGHTS_0"]);
  const gltf::Rig rig = [&] {
    const TemporaryFolder folder;
    return gltf::read_rig(folder.write("a.glb", b.glb()));
  }();
  double sum = 0.0;
  for (std::size_t k = 0; k < rig.parts[0].influence_offset[1]; ++k) sum += rig.parts[0].weight[k];
  EXPECT_NEAR(sum, 1.0, 1e-12);
  expect_sums_of_one(document);
}

}  // namespace
}  // namespace fascicle::tests
