// Meshes without a skin on a joint or a moving node, and meshes with several nodes.
#include <algorithm>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "host/base/errors.h"
#include "host/gltf/gltf.h"
#include "host/gltf/gltf_rig.h"
#include "host/rig/pose.h"
#include "tests/gltf/gltf_builder.h"
#include "tests/gltf/gltf_viewer.h"
#include "tests/support/assets.h"

namespace fascicle::tests::gltf_hung_test {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector3d;
using nlohmann::json;
using rig::Character;

// Matrices and coordinates of the generated files are floats near 1.
constexpr double hung_rounding = 1e-6;

Character read_hung(const GltfBuilder& builder) {
  const TemporaryFolder folder;
  return gltf::read_gltf(folder.write("robot.glb", builder.glb()));
}

gltf::Rig rig_of(const GltfBuilder& builder) {
  const TemporaryFolder folder;
  return gltf::read_rig(folder.write("robot.glb", builder.glb()));
}

// Adds a tetrahedron of edge 0.2 as a mesh without joints; returns its index.
std::size_t add_plate(GltfBuilder& b) {
  const std::size_t position = b.add("VEC3", std::vector<float>{0, 0, 0, 0.2f, 0, 0, 0, 0.2f, 0, 0, 0, 0.2f});
  const std::size_t index = b.add("SCALAR", std::vector<std::uint16_t>{0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3});
  b.document["meshes"].push_back(
      {{"name", "plate"}, {"primitives", {{{"attributes", {{"POSITION", position}}}, {"indices", index}}}}});
  return b.document["meshes"].size() - 1;
}

std::size_t add_node(GltfBuilder& b, json node, int parent) {
  b.document["nodes"].push_back(std::move(node));
  const std::size_t number = b.document["nodes"].size() - 1;
  if (parent < 0) {
    b.document["scenes"][0]["nodes"].push_back(number);
  } else {
    b.document["nodes"][static_cast<std::size_t>(parent)]["children"].push_back(number);
  }
  return number;
}

const json tilted = json::parse(
    R"({"name": "plate", "translation": [0.1, 0.2, 0.3], "rotation": [0, 0.6, 0, 0.8], "scale": [2, 1, 1]})");

// The column with a plate on a node below its upper joint.
GltfBuilder column_with_plate() {
  GltfBuilder b = column();
  json node = tilted;
  node["mesh"] = add_plate(b);
  add_node(b, std::move(node), 2);
  return b;
}

// No skin at all: a hip that a clip rotates, a still link below it, a foot at its end.
GltfBuilder rigid_robot() {
  GltfBuilder b = column_with_plate();
  b.document.erase("skins");
  b.document["nodes"][3] = {{"name", "spare"}};
  return b;
}

std::vector<Vector3d> skinned(const Character& c, int clip, double time) {
  const std::vector<Matrix4d> pose =
      rig::pose_at(c, clip < 0 ? nullptr : &c.clips.at(static_cast<std::size_t>(clip)), time);
  std::vector<Vector3d> result;
  for (std::size_t i = 0; i < c.surface.vertices.size(); ++i) {
    Eigen::Vector4d p = Eigen::Vector4d::Zero();
    for (std::size_t k = 0; k < 8; ++k)
      p += c.weights[i][k] * (pose[c.joints[i][k]] * c.surface.vertices[i].homogeneous());
    result.push_back(p.head<3>());
  }
  return result;
}

// The surface as the .glb of a bake sees the file.
std::vector<Vector3d> rigged(const gltf::Rig& rig, int clip, double time) {
  const Character& c = rig.character;
  const std::vector<Matrix4d> joints =
      rig::joint_transforms_at(c, clip < 0 ? nullptr : &c.clips.at(static_cast<std::size_t>(clip)), time);
  std::vector<Vector3d> result;
  for (const gltf::RigPart& part : rig.parts)
    for (std::size_t i = 0; i < part.positions.size(); ++i) {
      Eigen::Vector4d p = Eigen::Vector4d::Zero();
      for (std::size_t k = part.influence_offset[i]; k < part.influence_offset[i + 1]; ++k)
        p += part.weight[k] * (joints[part.skin_joint[part.slot[k]]] * part.inverse_bind[part.slot[k]] *
                               part.positions[i].homogeneous());
      result.push_back(p.head<3>());
    }
  return result;
}

double distance(const std::vector<Vector3d>& a, const std::vector<Vector3d>& b) {
  EXPECT_EQ(a.size(), b.size());
  double worst = 0.0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    worst = std::max(worst, (a[i] - b[i]).norm());
  return worst;
}

// The reader, the rig and an independent viewer agree at all times, and the clip moves the surface.
void expect_shown(const GltfBuilder& b, int clip) {
  const Character c = read_hung(b);
  const gltf::Rig rig = rig_of(b);
  const GltfViewer viewer(b);
  for (const double time : {0.0, 0.3, 1.0}) {
    EXPECT_LT(distance(skinned(c, clip, time), viewer.shown(clip, time)), hung_rounding) << time;
    EXPECT_LT(distance(rigged(rig, clip, time), viewer.shown(clip, time)), hung_rounding) << time;
  }
  // The control: the comparison detects a surface that stays behind.
  EXPECT_GT(distance(c.surface.vertices, viewer.shown(clip, 1.0)), 0.2);
}

TEST(GltfHung, a_mesh_below_a_joint_follows_it) {
  const GltfBuilder b = column_with_plate();
  const Character c = read_hung(b);
  ASSERT_EQ(c.surface.vertices.size(), 16u);
  ASSERT_EQ(c.parts.size(), 2u);
  EXPECT_EQ(c.parts[1].object, "plate");
  EXPECT_EQ(c.parts[1].node, 4u);
  EXPECT_EQ(c.parts[1].first_vertex, 12u);
  EXPECT_EQ(c.parts[1].triangle_count, 4u);
  ASSERT_EQ(c.skeleton.size(), 2u);  // the plate's node does not move on its joint, so it is not a joint
  for (std::size_t i = 12; i < 16; ++i) {
    EXPECT_EQ(c.joints[i][0], 1u);
    EXPECT_EQ(c.weights[i][0], 1.0);
  }
  EXPECT_TRUE(c.notes.empty());
  EXPECT_LT(distance(c.surface.vertices, GltfViewer(b).shown(-1, 0.0)), hung_rounding);
  expect_shown(b, 0);
  expect_shown(b, 1);
}

TEST(GltfHung, a_mesh_on_a_joint_or_on_a_moving_node_follows_it) {
  GltfBuilder b = column();
  const std::size_t plate = add_plate(b);
  b.document["nodes"][2]["mesh"] = plate;
  const std::size_t moving = add_node(b, {{"name", "lid"}, {"mesh", plate}}, 1);
  b.document["animations"][0]["channels"].push_back(
      {{"sampler", 0}, {"target", {{"node", moving}, {"path", "rotation"}}}});
  const Character c = read_hung(b);
  ASSERT_EQ(c.skeleton.size(), 3u);
  EXPECT_EQ(c.skeleton[2].name, "lid");
  EXPECT_TRUE(c.skeleton[2].skins);
  ASSERT_EQ(c.parts.size(), 3u);
  EXPECT_EQ(c.parts[0].object, "upper");  // in the order of nodes: 2, 3 and the new one
  EXPECT_EQ(c.parts[1].object, "body");
  expect_shown(b, 0);
}

// A plate below three still nodes.
GltfBuilder still_plate() {
  GltfBuilder b = rigid_robot();
  b.document.erase("animations");
  return b;
}

TEST(GltfHung, what_nothing_moves_is_carried_by_its_topmost_node_where_that_is_asked) {
  const GltfBuilder b = still_plate();
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.write("chair.glb", b.glb());
  EXPECT_THROW(gltf::read_gltf(file), base::SceneError);
  const Character c = gltf::read_gltf(file, nullptr, {}, gltf::Still::carried);
  ASSERT_EQ(c.skeleton.size(), 1u);
  EXPECT_EQ(c.skeleton[0].name, "armature");
  EXPECT_TRUE(c.skeleton[0].skins);
  EXPECT_TRUE(c.notes.empty());
  EXPECT_EQ(c.parts.at(0).object, "plate");
  const std::vector<Vector3d> shown = GltfViewer(b).shown(-1, 0.0);
  EXPECT_LT(distance(c.surface.vertices, shown), hung_rounding);
  const gltf::Rig rig = gltf::read_rig(file, {}, gltf::Still::carried);
  EXPECT_EQ(rig.joint_node, std::vector<std::uint32_t>{0});
  EXPECT_LT(distance(rigged(rig, -1, 0.0), shown), hung_rounding);
}

TEST(GltfHung, what_a_document_marks_carries) {
  GltfBuilder b = still_plate();
  b.document["nodes"][1]["extras"] = {{gltf::carries_mark, true}};
  const Character c = read_hung(b);
  ASSERT_EQ(c.skeleton.size(), 1u);
  EXPECT_EQ(c.skeleton[0].name, "lower");
  EXPECT_LT(distance(c.surface.vertices, GltfViewer(b).shown(-1, 0.0)), hung_rounding);
}

// If something moves, still meshes are left out: they hardly belong to it.
TEST(GltfHung, beside_what_moves_nothing_still_is_carried) {
  GltfBuilder b = column();
  add_node(b, {{"name", "ground"}, {"mesh", add_plate(b)}}, -1);
  const TemporaryFolder folder;
  const Character c = gltf::read_gltf(folder.write("man.glb", b.glb()), nullptr, {}, gltf::Still::carried);
  EXPECT_EQ(c.parts.size(), 1u);
  EXPECT_EQ(c.notes.size(), 1u);
}

TEST(GltfHung, a_file_without_any_skin_is_a_character_where_a_clip_moves_it) {
  const GltfBuilder b = rigid_robot();
  const Character c = read_hung(b);
  EXPECT_EQ(c.surface.vertices.size(), 4u);
  ASSERT_EQ(c.skeleton.size(), 2u);
  EXPECT_FALSE(c.skeleton[0].skins);
  EXPECT_TRUE(c.skeleton[1].skins);
  expect_shown(b, 0);
}

TEST(GltfHung, nodes_above_that_scale_and_turn_count) {
  GltfBuilder b = rigid_robot();
  b.document["nodes"][0]["rotation"] = {0.6, 0, 0, 0.8};
  b.document["nodes"][0]["scale"] = {3, 3, 3};
  expect_shown(b, 0);
}

// The inverse bind matrices of the skin put the joints elsewhere than the rest pose of the nodes; plates
// follow.
TEST(GltfHung, the_bind_pose_is_that_of_the_skin) {
  GltfBuilder b = column_with_plate();
  const std::size_t child = add_node(b, {{"name", "carrier"}, {"translation", {0.0, 0.1, 0.0}}}, 2);
  add_node(b, {{"name", "tip"}, {"mesh", 1}}, static_cast<int>(child));
  b.document["animations"][0]["channels"].push_back(
      {{"sampler", 0}, {"target", {{"node", child}, {"path", "rotation"}}}});
  const Character straight = read_hung(b);
  b.document["nodes"][2]["rotation"] = {0, 0, 0.6, 0.8};
  const Character posed = read_hung(b);
  EXPECT_LT(distance(straight.surface.vertices, posed.surface.vertices), hung_rounding);
  EXPECT_GT(distance(posed.surface.vertices, GltfViewer(b).shown(-1, 0.0)), 0.2);
  expect_shown(b, 0);
}

TEST(GltfHung, one_mesh_on_two_nodes_is_two_parts) {
  GltfBuilder b = column_with_plate();
  json node = tilted;
  node["name"] = "second plate";
  node["mesh"] = 1;
  node["translation"] = {-0.4, 0.2, 0.3};
  add_node(b, std::move(node), 1);
  const Character c = read_hung(b);
  ASSERT_EQ(c.parts.size(), 3u);
  EXPECT_EQ(c.parts[2].object, "second plate");
  EXPECT_EQ(c.joints[16][0], 0u);
  expect_shown(b, 0);
}

TEST(GltfHung, one_skinned_mesh_on_two_skeletons_is_two_bodies) {
  GltfBuilder b = column();
  add_node(b, {{"name", "other"}, {"children", {5}}, {"translation", {3, 0, 0}}}, -1);
  b.document["nodes"].push_back({{"name", "other lower"}, {"children", {6}}});
  b.document["nodes"].push_back({{"name", "other upper"}, {"translation", {0, 1, 0}}});
  b.document["skins"].push_back({{"joints", {5, 6}}, {"inverseBindMatrices", 4}});
  add_node(b, {{"name", "twin"}, {"mesh", 0}, {"skin", 1}}, -1);
  b.document["animations"][0]["channels"].push_back(
      {{"sampler", 0}, {"target", {{"node", 6}, {"path", "rotation"}}}});
  const Character c = read_hung(b);
  ASSERT_EQ(c.parts.size(), 2u);
  EXPECT_EQ(c.parts[1].object, "twin");
  for (std::size_t i = 0; i < 12; ++i)
    EXPECT_LT((c.surface.vertices[12 + i] - c.surface.vertices[i] - Vector3d(3, 0, 0)).norm(), hung_rounding);
  expect_shown(b, 0);
}

TEST(GltfHung, what_nothing_moves_is_left_out_and_named) {
  GltfBuilder b = column_with_plate();
  add_node(b, {{"name", "floor"}, {"mesh", 1}}, -1);
  add_node(b, {{"name", "gone"}, {"mesh", 1}, {"scale", {0, 0, 0}}}, 2);
  b.document["meshes"].push_back(b.document["meshes"][1]);
  b.document["meshes"][2]["primitives"][0]["mode"] = 1;
  add_node(b, {{"name", "wire"}, {"mesh", 2}}, 2);
  const Character c = read_hung(b);
  EXPECT_EQ(c.surface.vertices.size(), 16u);
  EXPECT_EQ(rig_of(b).parts.size(), 2u);
  ASSERT_EQ(c.notes.size(), 3u);
  EXPECT_NE(c.notes[0].find("`floor` is left out: nothing moves it"), std::string::npos) << c.notes[0];
  EXPECT_NE(c.notes[1].find("`gone` is left out: its scale is zero"), std::string::npos) << c.notes[1];
  EXPECT_NE(c.notes[2].find("`wire` is left out: it has points or lines"), std::string::npos) << c.notes[2];
}

// Hundreds of props would fill the terminal.
TEST(GltfHung, notes_name_the_first_that_are_left_out) {
  GltfBuilder b = column_with_plate();
  for (int k = 0; k < 50; ++k) add_node(b, {{"name", "stone"}, {"mesh", 1}}, -1);
  const Character c = read_hung(b);
  ASSERT_EQ(c.notes.size(), 21u);
  EXPECT_EQ(c.notes[20], "30 more meshes are left out");
}

// Each node of a chain takes from the one above it: 20,000 meshes below a chain of 1,000 nodes took 40 s.
TEST(GltfHung, what_hangs_on_a_long_chain_is_where_a_viewer_shows_it) {
  GltfBuilder b = column_with_plate();
  std::size_t above = 2;
  for (int k = 0; k < 1000; ++k)
    above = add_node(b, {{"name", "link"}, {"translation", {0.001, 0, 0}}}, static_cast<int>(above));
  for (int k = 0; k < 20'000; ++k) add_node(b, {{"name", "end"}, {"mesh", 1}}, static_cast<int>(above));
  const Character c = read_hung(b);
  ASSERT_EQ(c.parts.size(), 20'002u);
  const auto& all = c.surface.vertices;
  // The corner of the plate, a metre along x from the joint at a height of a metre.
  for (const std::size_t part : {2u, 20'001u})
    EXPECT_LT((all[c.parts[part].first_vertex] - Vector3d(1, 1, 0)).norm(), hung_rounding) << part;
}

TEST(GltfHung, a_file_that_nothing_moves_says_what_to_do) {
  GltfBuilder b = column_with_plate();
  b.document.erase("skins");
  b.document.erase("animations");
  b.document["nodes"][3] = {{"name", "spare"}};
  try {
    read_hung(b);
    FAIL() << "was read";
  } catch (const base::SceneError& error) {
    EXPECT_NE(std::string(error.what()).find("a still body as .ply or .obj"), std::string::npos)
        << error.what();
  }
}

class HungGltf : public testing::TestWithParam<const char*> {};

TEST_P(HungGltf, is_whole_and_moves_as_a_viewer_shows_it) {
  const std::filesystem::path path = asset(GetParam());
  FASCICLE_NEEDS_ASSET(path);
  const Character c = gltf::read_gltf(path);
  const gltf::Rig rig = gltf::read_rig(path);
  const GltfViewer viewer(path);
  ASSERT_EQ(c.parts.size(), rig.parts.size());
  std::size_t shown = 0;
  for (const json& node : viewer.document["nodes"]) shown += node.contains("mesh") ? 1 : 0;
  EXPECT_EQ(shown, 14u);
  std::vector<std::string> objects;
  for (std::size_t p = 0; p < c.parts.size(); ++p) {
    EXPECT_EQ(c.parts[p].node, rig.parts[p].node);
    EXPECT_EQ(c.parts[p].vertex_count, rig.parts[p].positions.size());
    if (objects.empty() || objects.back() != c.parts[p].object) objects.push_back(c.parts[p].object);
  }
  EXPECT_EQ(objects, (std::vector<std::string>{"Foot.L", "Torso", "Head", "Shoulder.L", "Arm.L", "Shoulder.R",
                                               "Arm.R", "Leg.L", "LowerLeg.L", "Leg.R", "LowerLeg.R",
                                               "Foot.R", "Hand.R", "Hand.L"}));
  for (const int clip : {0, 6}) {
    const double time = 0.37 * c.clips[static_cast<std::size_t>(clip)].duration;
    const std::vector<Vector3d> expected = viewer.shown(clip, time);
    // Millionths of a robot of about 4 m: weights and matrices are floats.
    EXPECT_LT(distance(skinned(c, clip, time), expected), 4e-6) << clip;
    EXPECT_LT(distance(rigged(rig, clip, time), expected), 4e-6) << clip;
  }
}

INSTANTIATE_TEST_SUITE_P(Real, HungGltf, testing::Values("RobotExpressive.glb"));

}  // namespace
}  // namespace fascicle::tests::gltf_hung_test
