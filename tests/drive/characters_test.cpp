// Several characters in one scene: each moves as it does alone, at its place, and they push each other.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "host/build/build.h"
#include "host/drive/drive_source.h"
#include "host/formats/character_file.h"
#include "host/formats/surface_objects.h"
#include "host/gltf/gltf.h"
#include "host/model/overlap.h"
#include "host/rig/pose.h"
#include "host/scene/scene_file.h"
#include "host/scene/solids.h"
#include "tests/drive/character_walk.h"
#include "tests/support/assets.h"

namespace fascicle::tests::characters_test {

namespace {

using Eigen::Vector3d;

double furthest(const std::vector<Vector3d>& a, std::size_t first, const std::vector<Vector3d>& b,
                const Eigen::Matrix3d& turn, const Vector3d& at) {
  double largest = 0.0;
  for (std::size_t i = 0; i < b.size(); ++i)
    largest = std::max(largest, (a[first + i] - (turn * b[i] + at)).norm());
  return largest;
}

TEST(Characters, FarApartMoveAsTheyDoAlone) {
  constexpr std::uint64_t frames = 60;
  const Walk alone = walk(arm("character") + flesh_on_bones, frames);
  const Walk both =
      walk(arm("character.a") + arm("character.b", "at = [3, 0.5, 0]\nturn = [0, 90, 0]\n") + flesh_on_bones,
           frames);
  ASSERT_EQ(both.model.vertex_count, 2 * alone.model.vertex_count);
  ASSERT_EQ(both.model.tetrahedron_count(), 2 * alone.model.tetrahedron_count());
  // The tetrahedra are the same, so only rounding differs. Positions are up to 2 m from the frame's origin,
  // which is between the two, so float spacing is 1.2e-7 m (alone: 6e-8 m). Springs of 1 Hz and more amplify
  // the effect of a substep's rounding on velocity by a few hundred.
  constexpr double rounding = 100.0 * 2.4e-7;
  const Eigen::Matrix3d turn = scene::turned_by({0, 90, 0});
  double moved = 0.0;
  for (std::uint64_t k = 0; k <= frames; ++k) {
    EXPECT_LT(furthest(both.surface[k], 0, alone.surface[k], Eigen::Matrix3d::Identity(), Vector3d::Zero()),
              rounding)
        << k;
    EXPECT_LT(furthest(both.surface[k], alone.surface[k].size(), alone.surface[k], turn, {3, 0.5, 0}),
              rounding)
        << k;
    moved = std::max(moved, furthest(alone.surface[k], 0, alone.surface[0], Eigen::Matrix3d::Identity(),
                                     Vector3d::Zero()));
  }
  EXPECT_GT(moved, 0.1) << "they do not move at all";
}

TEST(Characters, EachHasItsOwnStart) {
  const Walk both = walk(arm("character.a") + arm("character.b", "at = [0, 0, 3]\nstart = 0.25\n") +
                             "[motion]\npreroll = 0.0\n" + flesh_on_bones,
                         1);
  drive::DriveSource drives(both.scene, both.model);
  const std::size_t joints = both.scene.characters[1].first_joint;
  // 0.25 s is 15 frames. The poses are sums of the same doubles up to the last bits.
  for (const std::uint64_t k : {0u, 10u, 40u})
    for (std::size_t j = 1; j < joints; ++j) {
      const Eigen::Matrix4d early = drives.joints(k)[j], late = drives.joints(k + 15)[joints + j];
      Eigen::Matrix4d moved = early;
      moved(2, 3) += 3.0;
      EXPECT_LT((late - moved).norm(), 1e-12);
    }
}

const std::string meets = "self = true\n", does_not_meet = "ignore = [[\"a\", \"b\"]]\n";

// Arms side by side whose flesh overlaps by a third of its thickness.
std::string side_by_side(const std::string& contact, const std::string& of_b = "") {
  return arm("character.a") + arm("character.b", "at = [0, 0, 0.1]\n" + of_b) +
         "[motion]\npreroll = 0.0\n[contact]\n" + contact + flesh_on_bones;
}

TEST(Characters, PushEachOther) {
  constexpr std::uint64_t frames = 12;
  const Walk with = walk(side_by_side(meets), frames), without = walk(side_by_side(does_not_meet), frames);
  const model::OverlapMeter meter(with.model);
  const double left = meter.of(with.last.positions).volume, before = meter.of(without.last.positions).volume;
  EXPECT_GT(before, 1e-5) << "m^3: without contact they overlap";
  EXPECT_LT(left, 0.25 * before);
  // Both are pushed equally, in opposite directions. The bodies are the same, but one comes first in the
  // search and supplies the points, which makes a difference of a tenth.
  const Vector3d a = mean_move(with, without, 0), b = mean_move(with, without, 1);
  EXPECT_LT(a.z(), -5e-4);
  EXPECT_GT(b.z(), 5e-4);
  EXPECT_NEAR(a.z(), -b.z(), 0.1 * b.z());
}

TEST(Characters, ARigidOnePushesAndIsNotPushed) {
  constexpr std::uint64_t frames = 12;
  const std::string rigid = "rigid = true\n";
  const Walk with = walk(side_by_side(meets, rigid), frames),
             without = walk(side_by_side(does_not_meet, rigid), frames);
  EXPECT_LT(mean_move(with, without, 0).z(), -1e-3);
  EXPECT_EQ(mean_move(with, without, 1), Vector3d(0, 0, 0));
  // It stays at its skinned position.
  const std::uint32_t first = with.scene.characters[1].first_joint;
  std::size_t vertices = 0;
  for (std::uint32_t i = 0; i < with.model.vertex_count; ++i) {
    if (with.model.skin_joint[with.model.skin_offset[i]] < first) continue;
    ++vertices;
    EXPECT_TRUE(with.model.is_kinematic(i));
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_EQ(with.last.positions[3 * i + c], with.last.skinned[3 * i + c]);
  }
  EXPECT_EQ(2 * vertices, with.model.vertex_count);
}

// skeleton.only with joints of one character leaves no simulated flesh on the other.
TEST(Characters, OnlyTheJointsThatAreNamedAreSimulated) {
  const Walk some = walk(arm("character.a") + arm("character.b", "at = [0, 0, 3]\n") +
                             "[skeleton]\nonly = [\"a/forearm\"]\n" + flesh_on_bones,
                         1);
  std::size_t free = 0;
  for (std::uint32_t i = 0; i < some.model.vertex_count; ++i) {
    if (some.model.is_kinematic(i)) continue;
    ++free;
    EXPECT_LT(some.model.skin_joint[some.model.skin_offset[i]], some.scene.characters[1].first_joint);
  }
  EXPECT_GT(free, 0u);
}

// Shapes are placed in the bind pose of each character.
TEST(Characters, ShapesHoldForEachInItsOwnBindPose) {
  const std::string probe =
      "[probe.hand]\nwhere = { above = { axis = \"x\", fraction = 0.9 } }\n"
      "[probe.ball]\nwhere = { sphere = { center = [0.3, 0, 0], radius = 0.1 } }\n";
  const Walk alone = walk(arm("character") + probe + flesh_on_bones, 1);
  const Walk both =
      walk(arm("character.a") + arm("character.b", "at = [0, 0, 3]\n") + probe + flesh_on_bones, 1);
  for (std::size_t k = 0; k < 2; ++k) {
    ASSERT_GT(alone.model.probes[k].vertices.size(), 0u);
    EXPECT_EQ(both.model.probes[k].vertices.size(), 2 * alone.model.probes[k].vertices.size());
  }
}

// A character that jumps is carried over the cut with its flesh; the other one moves on normally.
TEST(Characters, AJumpOfOneIsACut) {
  scene::Scene scene = scene::parse_scene({"test",
                                           "test.toml",
                                           arm("character.a") + arm("character.b", "at = [0, 0, 3]\n") +
                                               "[motion]\npreroll = 0.0\n" + flesh_on_bones,
                                           {}},
                                          {});
  auto& clip = std::get<rig::Character>(scene.geometry).clips.at(0);
  const std::uint32_t top = scene.characters[1].first_joint;
  clip.channels.push_back({.joint = top,
                           .path = rig::ChannelPath::translation,
                           .interpolation = rig::Interpolation::step,
                           .times = {0.0, 0.5},
                           .values = {0, 0, 3, 0, 5, 3}});
  build::BuildOptions options;
  options.mesher = FASCICLE_MESHER;
  build::Report report;
  const model::Model model = build::build_model(scene, report, options);
  drive::DriveSource drives(scene, model);
  std::size_t cuts = 0;
  for (std::uint64_t k = 1; k <= 60; ++k) cuts += drives.drive(k).cuts.size();
  EXPECT_EQ(cuts, 1u);
}

// character.glb, which gives formats looks, objects and skeletons: its reader finds every character where the
// scene's skeleton puts it.
void expect_in_one_document(const std::string& text, std::size_t least_objects,
                            const std::filesystem::path& folder = asset("").parent_path()) {
  scene::Scene scene = scene::parse_scene({"test", "test.toml", text, folder}, {});
  build::BuildOptions options;
  options.mesher = FASCICLE_MESHER;
  build::Report report;
  const model::Model model = build::build_model(scene, report, options);
  drive::DriveSource drives(scene, model);
  std::vector<std::string> missing;
  const std::string bytes = formats::character_glb(
      scene, model, [&](std::uint64_t frame) { return drives.clip_time(frame); }, missing);
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "fascicle_characters.glb";
  std::ofstream(file, std::ios::binary) << bytes;

  const auto& character = std::get<rig::Character>(scene.geometry);
  const rig::Character read = gltf::read_gltf(file);
  ASSERT_EQ(read.parts.size(), character.parts.size());
  std::set<std::string> objects;
  for (const rig::SurfacePart& part : character.parts) objects.insert(part.object);
  EXPECT_GE(objects.size(), least_objects);
  EXPECT_GE(formats::read_surface_objects(model, file).objects.size(), least_objects);
  const gltf::Rig rig = gltf::read_rig(file);
  ASSERT_FALSE(read.clips.empty());
  EXPECT_EQ(read.clips[0].name, character.clips[0].name + " (baked)");
  for (const std::uint64_t frame : {0u, 7u}) {
    const std::vector<Eigen::Matrix4d> pose =
        rig::pose_at(character, &character.clips[0], drives.clip_time(frame));
    const std::vector<Eigen::Matrix4d> joints = formats::baked_joints(rig, true, frame, scene.fps);
    std::size_t i = 0;
    double furthest = 0.0;
    for (const gltf::RigPart& part : rig.parts)
      for (std::size_t v = 0; v < part.positions.size(); ++v, ++i) {
        Vector3d shown = Vector3d::Zero(), expected = Vector3d::Zero();
        for (std::size_t k = part.influence_offset[v]; k < part.influence_offset[v + 1]; ++k)
          shown += part.weight[k] * (joints[part.skin_joint[part.slot[k]]] * part.inverse_bind[part.slot[k]] *
                                     part.positions[v].homogeneous())
                                        .head<3>();
        for (std::size_t k = 0; k < 8; ++k)
          expected += character.weights[i][k] *
                      (pose[character.joints[i][k]] * character.surface.vertices[i].homogeneous()).head<3>();
        furthest = std::max(furthest, (shown - expected).norm());
      }
    EXPECT_EQ(i, character.surface.vertices.size());
    // Positions up to 4 m, through about ten joints stored as floats.
    EXPECT_LT(furthest, 10.0 * 4.8e-7) << frame;
  }
}

TEST(Characters, MadeOnesAreInOneGltf) {
  expect_in_one_document(arm("character.a", "start = 0.1\n") +
                             arm("character.b", "at = [1, 0.5, 0]\nturn = [0, 90, 0]\n") + flesh_on_bones,
                         2);
}

TEST(Characters, HeldOnesAreInOneGltf) {
  expect_in_one_document(
      arm("character.b", "joint = \"a/forearm\"\nat = [0.1, 0.2, 0]\nturn = [0, 90, 0]\n") +
          arm("character.a", "start = 0.1\nat = [1, 0.5, 0]\nturn = [0, 30, 0]\n") + flesh_on_bones,
      2);
}

// A still prop with a rotated and scaled part; and a prop with a clip, held in a hand, whose file has a
// ground that is left out.
TEST(Characters, PropsAreInOneGltf) {
  const TemporaryFolder folder;
  GltfBuilder chair = boxes({{{0, 0, 0}, {0.5, 0.5, 0.5}}, {{0, 0.5, 0}, {0.5, 1, 0.1}}});
  chair.document["nodes"][1]["rotation"] = {0, 0.6, 0, 0.8};
  chair.document["nodes"][1]["scale"] = {2, 1, 1};
  folder.write("chair.glb", chair.glb());
  GltfBuilder sword = boxes({{{-1, -1, -1}, {1, -0.9, 1}}, {{-0.1, 0, 0}, {0.6, 0.05, 0.05}}});
  const std::size_t times = sword.add("SCALAR", std::vector<float>{0, 1}, {{"min", {0}}, {"max", {1}}});
  const std::size_t turns = sword.add("VEC4", std::vector<float>{0, 0, 0, 1, 0, 0.6f, 0, 0.8f});
  sword.document["animations"] = {
      {{"samplers", {{{"input", times}, {"output", turns}}}},
       {"channels", {{{"sampler", 0}, {"target", {{"node", 1}, {"path", "rotation"}}}}}}}};
  folder.write("sword.glb", sword.glb());
  expect_in_one_document(arm("character.a", "at = [1, 0.5, 0]\nturn = [0, 30, 0]\n") +
                             "[character.chair]\nfile = \"chair.glb\"\nrigid = true\nresolution = 0.1\n"
                             "[character.sword]\nfile = \"sword.glb\"\nrigid = true\nresolution = 0.05\n"
                             "joint = \"a/hand\"\n" +
                             flesh_on_bones,
                         4, folder.path());
}

TEST(Characters, OnesFromFilesAreInOneGltf) {
  FASCICLE_NEEDS_ASSET(asset("CesiumMan.glb"));
  FASCICLE_NEEDS_ASSET(asset("animals_pack_Fox.glb"));
  expect_in_one_document("[character.man]\nfile = \"CesiumMan.glb\"\nat = [1, 0.5, 0]\nturn = [0, 90, 0]\n" +
                             arm("character.arm") +
                             "[character.fox]\nfile = \"animals_pack_Fox.glb\"\nat = [-2, 0, 0]\n" +
                             arm("character.sword", "joint = \"man/Skeleton_arm_joint_R\"\n") +
                             "[body]\nresolution = \"3000\"\n" + flesh_on_bones,
                         4);
}

}  // namespace

}  // namespace fascicle::tests::characters_test
