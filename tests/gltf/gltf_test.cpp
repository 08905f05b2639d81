#include "host/gltf/gltf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Dense>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/mesh/mesh.h"
#include "host/rig/pose.h"
#include "tests/gltf/gltf_builder.h"
#include "tests/gltf/gltf_read.h"
#include "tests/gltf/gltf_viewer.h"
#include "tests/support/assets.h"

namespace fascicle::tests::gltf_test {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector3d;
using nlohmann::json;
using rig::Character;

std::vector<Vector3d> skinned(const Character& character, const rig::Clip* clip, double time) {
  const std::vector<Matrix4d> pose = rig::pose_at(character, clip, time);
  std::vector<Vector3d> result;
  for (std::size_t i = 0; i < character.surface.vertices.size(); ++i) {
    Vector3d p = Vector3d::Zero();
    for (std::size_t k = 0; k < 8; ++k) {
      const Eigen::Vector4d moved =
          pose[character.joints[i][k]] * character.surface.vertices[i].homogeneous();
      p += character.weights[i][k] * moved.head<3>();
    }
    result.push_back(p);
  }
  return result;
}

// Signed: positive if triangles are counter-clockwise from outside.
double volume(const mesh::SurfaceMesh& surface) {
  double sum = 0.0;
  for (const auto& t : surface.triangles) {
    sum += surface.vertices[t[0]].dot(surface.vertices[t[1]].cross(surface.vertices[t[2]])) / 6.0;
  }
  return sum;
}

double height(const Character& character) {
  double low = 1e300, high = -1e300;
  for (const Vector3d& p : character.surface.vertices)
    low = std::min(low, p.y()), high = std::max(high, p.y());
  return high - low;
}

TEST(Gltf, column_stands_in_metres_with_y_up) {
  const Character c = read(column());
  ASSERT_EQ(c.surface.vertices.size(), 12u);
  ASSERT_EQ(c.surface.triangles.size(), 16u);
  // The body's node is at (50, 60, 70), but a skinned mesh ignores the transform of its node.
  EXPECT_LT((c.surface.vertices[0] - Vector3d(-0.25, 0, 0.25)).norm(), float_rounding);
  EXPECT_LT((c.surface.vertices[6] - Vector3d(0.25, 1, -0.25)).norm(), float_rounding);
  EXPECT_NEAR(height(c), 2.0, float_rounding);
  EXPECT_GT(volume(c.surface), 0.0);
  ASSERT_EQ(c.skeleton.size(), 2u);  // the armature has no weights and does not move
  EXPECT_EQ(c.skeleton[0].name, "lower");
  EXPECT_EQ(c.skeleton[1].parent, 0);
  EXPECT_TRUE(c.skeleton[0].skins && c.skeleton[1].skins);
  EXPECT_EQ(c.weights[4][0], 0.5);
  ASSERT_EQ(c.clips.size(), 2u);
  EXPECT_EQ(c.clips[0].name, "bend");
  EXPECT_EQ(c.clips[0].duration, 1.0);
}

TEST(Gltf, column_bends) {
  const Character c = read(column());
  const std::vector<Vector3d> p = skinned(c, rig::find_clip(c, "bend"), 1.0);
  EXPECT_LT((p[0] - c.surface.vertices[0]).norm(), float_rounding);
  // A quarter turn about an axis along z through (0, 1, 0) takes (0.25, 2) to (-1, 1.25).
  EXPECT_LT((p[9] - Vector3d(-1, 1.25, 0.25)).norm(), float_rounding);
}

// So that a scene can name them.
TEST(Gltf, joints_without_a_name_have_their_nodes_number) {
  GltfBuilder b = column();
  b.document["nodes"][1].erase("name");
  b.document["nodes"][2]["name"] = "";
  std::vector<std::string> names;
  for (const rig::Joint& joint : read(b).skeleton) names.push_back(joint.name);
  EXPECT_EQ(names, (std::vector<std::string>{"node 1", "node 2"}));
}

TEST(Gltf, glb_and_external_buffers_read_alike) {
  const GltfBuilder builder = column();
  const Character inside = read(builder);
  const TemporaryFolder folder;
  const Character glb = gltf::read_gltf(folder.write("a.glb", builder.glb()));
  json document = builder.document;
  document["buffers"] = {{{"byteLength", builder.bytes.size()}, {"uri", "parts/my%20data.bin"}}};
  folder.write("parts/my data.bin", builder.bytes);
  std::vector<std::filesystem::path> files;
  const Character outside = gltf::read_gltf(folder.write("b.gltf", document.dump()), &files);
  EXPECT_EQ(inside.surface.vertices, glb.surface.vertices);
  EXPECT_EQ(inside.surface.vertices, outside.surface.vertices);
  ASSERT_EQ(files.size(), 1u);
  EXPECT_EQ(files[0].filename(), "my data.bin");
}

TEST(Gltf, an_animated_node_above_the_joints_is_kept) {
  GltfBuilder b = column();
  b.document["animations"][1]["channels"][0]["target"]["node"] = 0;
  const Character c = read(b);
  ASSERT_EQ(c.skeleton.size(), 3u);
  EXPECT_FALSE(c.skeleton[0].skins);
  const std::vector<Vector3d> p = skinned(c, rig::find_clip(c, "lift"), 0.5);
  for (std::size_t i = 0; i < p.size(); ++i) {
    EXPECT_LT((p[i] - c.surface.vertices[i] - Vector3d(0, 1, 0)).norm(), float_rounding);
  }
}

TEST(Gltf, nodes_above_scale_turn_and_mirror) {
  const Character plain = read(column());
  GltfBuilder b = column();
  b.document["nodes"][0]["matrix"] = {-3, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1, 0, 10, 0, 0, 1};
  const Character c = read(b);
  ASSERT_EQ(c.skeleton.size(), 2u);
  for (std::size_t i = 0; i < 12; ++i) {
    const Vector3d p = plain.surface.vertices[i];
    EXPECT_LT((c.surface.vertices[i] - Vector3d(10 - 3 * p.x(), 2 * p.y(), p.z())).norm(),
              10 * float_rounding);
  }
  // Mirrored, but not inside out. The surface is open, so undo the shift, which changes its volume.
  mesh::SurfaceMesh surface = c.surface;
  for (Vector3d& p : surface.vertices) p.x() -= 10;
  EXPECT_NEAR(volume(surface), 6 * volume(plain.surface), 20 * float_rounding);
  for (const Matrix4d& map : rig::pose_at(c, nullptr, 0.0)) {
    EXPECT_LT((map - Matrix4d::Identity()).cwiseAbs().maxCoeff(),
              1e-14);  // a few operations on numbers up to 10
  }
}

TEST(Gltf, a_joint_with_negative_scale) {
  GltfBuilder b = column();
  b.document["nodes"][1]["scale"] = {1, 1, -2};
  const Character c = read(b);
  const Character plain = read(column());
  EXPECT_LT((c.surface.vertices[0] - Vector3d(-0.25, 0, -0.5)).norm(), float_rounding);
  EXPECT_NEAR(volume(c.surface), 2 * volume(plain.surface), 4 * float_rounding);
  EXPECT_LT((rig::pose_at(c, nullptr, 0)[1] - Matrix4d::Identity()).cwiseAbs().maxCoeff(), 1e-14);
}

// The body is the bind pose, whatever rest pose the nodes have, and skinning it gives the file's pose.
TEST(Gltf, where_the_nodes_rest_in_another_pose_the_bind_pose_is_the_body) {
  GltfBuilder b = column();
  b.document["nodes"][2]["rotation"] = {0, 0, std::sqrt(0.5), std::sqrt(0.5)};
  const Character c = read(b), plain = read(column());
  const std::vector<Vector3d> p = skinned(c, nullptr, 0.0);
  for (std::size_t i = 0; i < p.size(); ++i)
    EXPECT_LT((c.surface.vertices[i] - plain.surface.vertices[i]).norm(), float_rounding);
  EXPECT_LT((p[9] - Vector3d(-1, 1.25, 0.25)).norm(), float_rounding);
  EXPECT_LT((p[0] - c.surface.vertices[0]).norm(), float_rounding);
}

// Without inverse bind matrices, joints are bound at their rest pose.
TEST(Gltf, a_skin_without_matrices_is_bound_where_its_nodes_stand) {
  GltfBuilder b = column();
  b.document["skins"][0].erase("inverseBindMatrices");
  const Character c = read(b);
  const std::vector<Vector3d> p = skinned(c, nullptr, 0.0);
  for (std::size_t i = 0; i < p.size(); ++i)
    EXPECT_LT((p[i] - c.surface.vertices[i]).norm(), 100 * float_rounding);  // coordinates of about 100
}

TEST(Gltf, what_is_done_to_weights_is_noted) {
  GltfBuilder b = column();
  EXPECT_TRUE(read(b).notes.empty());
  std::vector<float> weights(48, 0.0f);
  for (std::size_t i = 0; i < 48; i += 4) weights[i] = i < 8 ? 0.5f : 1.0f;
  b.document["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = b.add("VEC4", weights);
  const Character c = read(b);
  ASSERT_EQ(c.notes.size(), 1u);
  EXPECT_EQ(c.notes[0],
            "skin weights: 2 of 12 vertices had weights that do not sum to 1; they were normalised");
}

TEST(Gltf, vertices_without_weights_go_with_what_they_are_connected_to) {
  GltfBuilder b = column();
  const Character whole = read(b);
  std::vector<float> weights(48, 0.0f);
  for (std::size_t i = 0; i < 48; i += 4) weights[i] = i == 8 || i == 20 ? 0.0f : 1.0f;  // vertices 2 and 5
  b.document["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = b.add("VEC4", weights);
  const Character c = read(b);
  ASSERT_EQ(c.notes.size(), 1u);
  EXPECT_EQ(c.notes[0],
            "skin weights: 2 of 12 vertices followed no joint; they have the weights of what they are "
            "connected to");
  for (const std::uint32_t v : {2u, 5u}) {
    bool has_neighbour = false;
    for (const auto& t : c.surface.triangles)
      if (std::ranges::find(t, v) != t.end())
        for (const std::uint32_t other : t)
          has_neighbour = has_neighbour ||
                          (other != v && c.joints[other] == c.joints[v] && c.weights[other] == c.weights[v]);
    EXPECT_TRUE(has_neighbour) << v;
  }
}

TEST(Gltf, strips_and_fans_become_triangles) {
  using Triangle = std::array<std::uint32_t, 3>;
  GltfBuilder b = column();
  json& primitive = b.document["meshes"][0]["primitives"][0];
  primitive["mode"] = 5;
  primitive["indices"] = b.add("SCALAR", std::vector<std::uint8_t>{0, 1, 4, 5, 5, 8, 8, 9, 4});
  EXPECT_EQ(read(b).surface.triangles,
            (std::vector<Triangle>{{0, 1, 4}, {1, 5, 4}, {8, 9, 4}}));  // without four degenerate ones
  primitive["mode"] = 6;
  primitive["indices"] = b.add("SCALAR", std::vector<std::uint32_t>{0, 1, 5, 4, 8});
  EXPECT_EQ(read(b).surface.triangles, (std::vector<Triangle>{{0, 1, 5}, {0, 5, 4}, {0, 4, 8}}));
  primitive.erase("indices");
  primitive["mode"] = 4;
  EXPECT_EQ(read(b).surface.triangles, (std::vector<Triangle>{{0, 1, 2}, {3, 4, 5}, {6, 7, 8}, {9, 10, 11}}));
}

TEST(Gltf, primitives_and_meshes_are_concatenated) {
  GltfBuilder b = column();
  json& primitives = b.document["meshes"][0]["primitives"];
  primitives.push_back(primitives[0]);
  b.document["nodes"].push_back({{"mesh", 0}, {"skin", 0}});
  b.document["nodes"].push_back({{"mesh", 0}});               // ignored: no skin
  b.document["nodes"].push_back({{"mesh", 0}, {"skin", 0}});  // ignored: not in the scene
  b.document["scenes"][0]["nodes"] = {0, 4, 3, 5};
  const Character c = read(b);
  ASSERT_EQ(c.surface.vertices.size(), 48u);
  EXPECT_EQ(c.surface.triangles[16][0], c.surface.triangles[0][0] + 12);
  EXPECT_EQ(c.surface.triangles[63][1], c.surface.triangles[15][1] + 36);
  EXPECT_EQ(c.surface.vertices[47], c.surface.vertices[11]);
}

TEST(Gltf, normalised_quantised_and_strided_accessors) {
  const Character plain = read(column());
  GltfBuilder b = column();
  json& attributes = b.document["meshes"][0]["primitives"][0]["attributes"];
  std::vector<std::uint16_t> weights, joints;
  std::vector<std::int8_t> positions;
  for (std::size_t i = 0; i < 12; ++i) {
    const auto upper = static_cast<std::uint16_t>(i / 4 * 32767);  // 0, nearly half, nearly all
    weights.insert(weights.end(), {static_cast<std::uint16_t>(65535 - upper), upper, 0, 0});
    joints.insert(joints.end(), {0, 1, 0, 0});
    // Both -127 and -128 mean -1. A fourth byte of padding makes the stride.
    const Vector3d p = plain.surface.vertices[i];
    const auto byte = [](double x) { return static_cast<std::int8_t>(x < 0 ? -128 : x > 0 ? 127 : 0); };
    positions.insert(positions.end(), {byte(p.x()), byte(-p.z()), byte(p.y()), 99});
  }
  attributes["WEIGHTS_0"] = b.add("VEC4", weights, {{"normalized", true}});
  attributes["JOINTS_0"] = b.add("VEC4", joints);
  const std::size_t position = b.add("VEC4", positions);
  b.document["accessors"][position].update({{"type", "VEC3"}, {"normalized", true}});
  b.document["bufferViews"].back()["byteStride"] = 4;
  attributes["POSITION"] = position;
  b.document["extensionsRequired"] = {"KHR_mesh_quantization"};
  const Character c = read(b);
  EXPECT_NEAR(c.weights[4][0], 32768.0 / 65535.0, 1e-15);
  EXPECT_NEAR(c.weights[4][1], 32767.0 / 65535.0, 1e-15);
  EXPECT_LT((c.surface.vertices[0] - Vector3d(-0.01, 0, 0.01)).norm(), float_rounding);
  EXPECT_LT((c.surface.vertices[6] - Vector3d(0.01, 0.01, -0.01)).norm(), float_rounding);
}

TEST(Gltf, sparse_accessors) {
  GltfBuilder b = column();
  json& attributes = b.document["meshes"][0]["primitives"][0]["attributes"];
  const std::size_t indices = b.add_view(std::vector<std::uint8_t>{2, 9});
  const std::size_t values = b.add_view(std::vector<float>{100, 200, 300, -100, -200, -300});
  const json sparse{{"count", 2},
                    {"indices", {{"bufferView", indices}, {"componentType", 5121}}},
                    {"values", {{"bufferView", values}}}};
  b.document["accessors"][attributes["POSITION"].get<std::size_t>()]["sparse"] = sparse;
  const Character over_data = read(b), plain = read(column());
  EXPECT_LT((over_data.surface.vertices[2] - Vector3d(1, 3, -2)).norm(), float_rounding);
  EXPECT_EQ(over_data.surface.vertices[3], plain.surface.vertices[3]);
  b.document["accessors"].push_back(
      {{"componentType", 5126}, {"type", "VEC3"}, {"count", 12}, {"sparse", sparse}});
  attributes["POSITION"] = b.document["accessors"].size() - 1;
  const Character over_zeros = read(b);
  EXPECT_LT((over_zeros.surface.vertices[9] - Vector3d(-1, -3, 2)).norm(), float_rounding);
  EXPECT_LT(over_zeros.surface.vertices[3].norm(), float_rounding);
}

TEST(Gltf, the_eight_largest_of_twelve_weights_are_kept) {
  GltfBuilder b = column();
  json& nodes = b.document["nodes"];
  std::vector<float> matrices;
  for (std::size_t j = 0; j < 12; ++j) {
    nodes.push_back({{"name", "joint" + std::to_string(j)}});
    b.document["scenes"][0]["nodes"].push_back(4 + j);
    for (std::size_t k = 0; k < 16; ++k) matrices.push_back(k % 5 == 0 ? 1.0f : 0.0f);
  }
  b.document["skins"][0]["joints"] = {4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  b.document["skins"][0]["inverseBindMatrices"] = b.add("MAT4", matrices);
  json& attributes = b.document["meshes"][0]["primitives"][0]["attributes"];
  for (std::size_t set = 0; set < 3; ++set) {
    std::vector<std::uint8_t> joints;
    std::vector<float> weights;
    for (std::size_t i = 0; i < 12; ++i) {
      for (std::size_t k = 0; k < 4; ++k) {
        joints.push_back(static_cast<std::uint8_t>(4 * set + k));
        weights.push_back(static_cast<float>(1 + 4 * set + k));  // 1 to 12, which do not sum to 1
      }
    }
    attributes["JOINTS_" + std::to_string(set)] = b.add("VEC4", joints);
    attributes["WEIGHTS_" + std::to_string(set)] = b.add("VEC4", weights);
  }
  const Character c = read(b);
  ASSERT_EQ(c.skeleton.size(), 12u);
  double sum = 0.0;
  for (std::size_t k = 0; k < 8; ++k) {
    EXPECT_EQ(c.skeleton[c.joints[0][k]].name, "joint" + std::to_string(11 - k));
    EXPECT_NEAR(c.weights[0][k], static_cast<double>(12 - k) / 68.0, 1e-15);  // 12 + 11 + ... + 5 = 68
    sum += c.weights[0][k];
  }
  EXPECT_NEAR(sum, 1.0, 1e-15);
}

TEST(Gltf, interpolations_of_a_channel) {
  GltfBuilder b = column();
  const std::size_t spline =
      b.add("VEC3", std::vector<float>{0, 0, 0, 0, 0, 0, 0, 3, 0, 0, 3, 0, 0, 1, 0, 0, 0, 0});
  json& sampler = b.document["animations"][1]["samplers"][0];
  sampler["output"] = spline;
  sampler["interpolation"] = "CUBICSPLINE";
  const Character c = read(b);
  // From 0 to 1 with slope 3 at both ends: 3u - 6u^2 + 4u^3.
  for (const double u : {0.0, 0.25, 0.5, 1.0}) {
    const Matrix4d map = rig::pose_at(c, rig::find_clip(c, "lift"), u)[0];
    EXPECT_NEAR(map(1, 3), 3 * u - 6 * u * u + 4 * u * u * u, 1e-15) << u;
  }
  GltfBuilder stepped = column();
  stepped.document["animations"][1]["samplers"][0]["interpolation"] = "STEP";
  const Character s = read(stepped);
  EXPECT_EQ(rig::pose_at(s, rig::find_clip(s, "lift"), 0.99)[0](1, 3), 0.0);
  EXPECT_EQ(rig::pose_at(s, rig::find_clip(s, "lift"), 1.0)[0](1, 3), 2.0);
}

// Looks and morph targets may be invalid: they are not needed.
TEST(Gltf, what_is_not_needed_is_not_believed) {
  GltfBuilder b = column();
  b.document["images"] = {{{"uri", "../../../../etc/passwd"}}, {{"bufferView", 4000000}}, 7};
  b.document["materials"] = {{{"pbrMetallicRoughness", 5}}};
  b.document["cameras"] = "none";
  b.document["animations"][0]["channels"].push_back(
      {{"sampler", 0}, {"target", {{"path", "weights"}, {"node", 3}}}});
  b.document["extensionsRequired"] = {"KHR_materials_unlit", "VRMC_vrm", "EXT_texture_webp",
                                      "KHR_animation_pointer", "KHR_lights_punctual"};
  b.document["extras"] = {{"anything", {1, 2, 3}}};
  EXPECT_EQ(read(b).surface.vertices, read(column()).surface.vertices);
}

class RealGltf : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    path_ = asset(GetParam());
    FASCICLE_NEEDS_ASSET(path_);
  }
  std::filesystem::path path_;
};

class WalkingMan : public RealGltf {};

TEST_P(WalkingMan, has_what_the_file_says) {
  const Character c = gltf::read_gltf(path_);
  EXPECT_EQ(c.surface.vertices.size(), 3273u);
  EXPECT_EQ(c.surface.triangles.size(), 4672u);
  EXPECT_EQ(c.skeleton.size(), 19u);
  ASSERT_EQ(c.clips.size(), 1u);
  EXPECT_EQ(c.clips[0].duration, 2.0);
  EXPECT_EQ(c.clips[0].channels.size(), 57u);
  EXPECT_NEAR(height(c), 1.50655, 1e-4);  // the z range that the file gives for its positions
  EXPECT_GT(volume(c.surface), 0.0);
  for (const auto& weights : c.weights) {
    double sum = 0.0;
    for (const double w : weights) sum += w;
    EXPECT_NEAR(sum, 1.0, 1e-15);
  }
}

INSTANTIATE_TEST_SUITE_P(Cesium, WalkingMan, testing::Values("CesiumMan.glb"));

class SkinnedAlike : public RealGltf {};

// Products are doubles, but the files' weights are floats and bytes, whose sum is 1 only up to rounding.
TEST_P(SkinnedAlike, as_an_independent_evaluation) {
  const Character c = gltf::read_gltf(path_);
  const GltfViewer viewer(path_);
  for (const double time : {0.0, 0.04, 0.333, 1.0, 1.9999, 2.0, 50.0}) {
    const std::vector<Vector3d> got = skinned(c, rig::find_clip(c, ""), time),
                                expected = viewer.shown(0, time);
    ASSERT_EQ(got.size(), expected.size());
    double worst = 0.0;
    for (std::size_t i = 0; i < expected.size(); ++i) worst = std::max(worst, (got[i] - expected[i]).norm());
    EXPECT_LT(worst, 1e-6 * height(c)) << "at " << time;
  }
}

INSTANTIATE_TEST_SUITE_P(Real, SkinnedAlike,
                         testing::Values("CesiumMan.glb", "mh_fat.glb", "animals_pack_Fox.glb"));

class RestPose : public RealGltf {};

// In these files the nodes rest in the bind pose; their inverse bind matrices are floats.
TEST_P(RestPose, is_the_identity) {
  const Character c = gltf::read_gltf(path_);
  EXPECT_GT(volume(c.surface), 0.0);
  for (const Matrix4d& map : rig::pose_at(c, nullptr, 0.0)) {
    EXPECT_LT((map - Matrix4d::Identity()).cwiseAbs().maxCoeff(), 2e-6);
  }
  for (const rig::Clip& clip : c.clips) {
    for (const Vector3d& p : skinned(c, &clip, 0.7 * clip.duration)) ASSERT_TRUE(p.allFinite());
  }
}

INSTANTIATE_TEST_SUITE_P(Real, RestPose,
                         testing::Values("CesiumMan.glb", "mh_fat.glb", "mh_muscle.glb",
                                         "mh_fat_selfint.glb"));

// A parser's complaint about the first byte helps nobody.
TEST(GltfFile, ThatIsSomethingElseSaysWhat) {
  const TemporaryFolder folder;
  const auto refusal = [&](const std::string& name, const std::string& bytes) {
    const std::filesystem::path path = folder.write(name, bytes);
    try {
      gltf::read_gltf(path);
    } catch (const base::SceneError& error) {
      return std::string(error.what()).substr(path.string().size());
    }
    return std::string("was read");
  };
  EXPECT_EQ(refusal("a.glb", ""), " is empty; export it again");
  EXPECT_EQ(refusal("b.glb", "version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 9\n"),
            " is a pointer of Git LFS, and the file itself is not here; `git lfs pull` gets it");
  EXPECT_EQ(refusal("c.gltf", std::string("Kaydara FBX Binary  \0\x1a\0", 23)),
            " is an FBX file; give it a name that ends in .fbx");
  EXPECT_NE(refusal("d.glb", "OFF\n3 1 0\n").find(" is not glTF"), std::string::npos);
  EXPECT_EQ(refusal("e.fbx", "glTF\2\0\0\0"), " is glTF; give it a name that ends in .glb");
  // The control: JSON after a byte order mark and spaces is read as glTF, and refused for what it says.
  EXPECT_EQ(refusal("f.gltf", "\xEF\xBB\xBF \n{\"asset\":{\"version\":\"1.0\"}}").substr(0, 2), ": ");
}

}  // namespace
}  // namespace fascicle::tests::gltf_test
