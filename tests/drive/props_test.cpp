// Props: rigid characters, still or held by a joint of another character. They push flesh.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "host/drive/drive_source.h"
#include "host/drive/timeline.h"
#include "host/model/overlap.h"
#include "host/scene/scene_file.h"
#include "host/scene/solids.h"
#include "tests/drive/character_walk.h"

namespace fascicle::tests::props_test {

namespace {

using Eigen::Matrix4d;
using Eigen::Vector3d;

class Props : public testing::Test {
 protected:
  Props() { std::filesystem::create_directories(folder_); }
  ~Props() override { std::filesystem::remove_all(folder_); }
  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) /
      (std::string("fascicle_props_") + testing::UnitTest::GetInstance()->current_test_info()->name());
};

Vector3d image(const Matrix4d& map, const Vector3d& p) {
  return map.topLeftCorner<3, 3>() * p + map.topRightCorner<3, 1>();
}

const std::string meets = "self = true\n", does_not_meet = "ignore = [[\"a\", \"b\"]]\n";

// Beside the arm, a third of its thickness deep in its flesh; exact in float.
const Box beside_arm{{0.0625, -0.15625, 0.03125}, {0.4375, 0.15625, 0.34375}};

void write(const std::filesystem::path& file, const GltfBuilder& builder) {
  const std::vector<unsigned char> bytes = builder.glb();
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

// A still mesh pushes flesh out and stays where the scene puts it. The control: without contact the flesh
// overlaps it. `at` places the file's origin: the same box elsewhere in its file gives the same result.
TEST_F(Props, AStillMeshPushesAndIsNotPushed) {
  constexpr std::uint64_t frames = 12;
  write_box(folder() / "box.obj", {0.05, -0.15, 0.04}, {0.45, 0.15, 0.34});
  write_box(folder() / "moved.obj", {1.05, -0.15, -0.96}, {1.45, 0.15, -0.66});
  const auto beside = [&](const std::string& prop, const std::string& contact) {
    return walk(arm("character.a") + "[character.b]\nresolution = 0.05\nrigid = true\n" + prop +
                    "[motion]\npreroll = 0.0\n[contact]\n" + contact + flesh_on_bones,
                frames, folder());
  };
  const Walk with = beside("file = \"box.obj\"\n", meets),
             without = beside("file = \"box.obj\"\n", does_not_meet),
             moved = beside("file = \"moved.obj\"\nat = [-1, 0, 1]\n", meets);
  const model::OverlapMeter meter(with.model);
  EXPECT_GT(meter.of(without.last.positions).volume, 1e-5) << "m^3";
  EXPECT_LT(meter.of(with.last.positions).volume, 0.25 * meter.of(without.last.positions).volume);
  EXPECT_LT(mean_move(with, without, 0).z(), -5e-4) << "m: the arm's mean, away from the box";
  EXPECT_EQ(mean_move(with, without, 1), Vector3d(0, 0, 0));
  const rig::SurfacePart& prop = std::get<rig::Character>(with.scene.geometry).parts.at(1);
  ASSERT_EQ(prop.vertex_count, 8u);
  for (std::size_t k = 0; k < 8; ++k) {
    const Vector3d corner(k & 1 ? 0.45 : 0.05, k & 2 ? 0.15 : -0.15, k & 4 ? 0.34 : 0.04);
    // Floats of positions up to 2 m.
    EXPECT_LT((with.surface.back()[prop.first_vertex + k] - corner).norm(), 1e-6);
    EXPECT_LT((moved.surface.back()[prop.first_vertex + k] - corner).norm(), 1e-6);
  }
  // Rounding of the corners gives the box a different cage, and so a different depth below its surface.
  EXPECT_NEAR(mean_move(moved, without, 0).z(), mean_move(with, without, 0).z(),
              0.25 * std::abs(mean_move(with, without, 0).z()));
}

// The arm beside a prop from this file, with contact.
Walk beside_prop(const std::string& file, const std::filesystem::path& folder,
                 const std::string& resolution = "resolution = 0.05\n") {
  return walk(arm("character.a") + "[character.b]\nrigid = true\nfile = \"" + file + "\"\n" + resolution +
                  "[motion]\npreroll = 0.0\n[contact]\n" + meets + flesh_on_bones,
              6, folder);
}

TEST_F(Props, AStillGltfIsTheSameMesh) {
  write_box(folder() / "box.obj", beside_arm.low, beside_arm.high);
  // Under a node at the origin, like the joint of the mesh: the frame's origin depends on the joints.
  GltfBuilder below = boxes({beside_arm});
  below.document["nodes"].push_back({{"name", "thing"}, {"children", {0}}});
  below.document["scenes"][0]["nodes"] = {1};
  write(folder() / "box.glb", below);
  const Walk mesh = beside_prop("box.obj", folder()), gltf = beside_prop("box.glb", folder());
  EXPECT_TRUE(mesh.last.positions == gltf.last.positions);
  EXPECT_TRUE(mesh.surface == gltf.surface);
  EXPECT_EQ(gltf.scene.motion.interpolation, mesh.scene.motion.interpolation);
}

// Small parts of a prop are not ornaments that ride on it: they push too.
TEST_F(Props, EveryPartPushes) {
  const Box far{{3.0, 0.0, 3.0}, {3.6, 0.6, 3.6}}, further{{3.0, 0.0, 5.0}, {3.6, 0.6, 5.6}};
  write(folder() / "near.glb", boxes({beside_arm}));
  write(folder() / "both.glb", boxes({far, beside_arm, further}));
  write(folder() / "far.glb", boxes({far}));
  const Walk near = beside_prop("near.glb", folder()), both = beside_prop("both.glb", folder()),
             none = beside_prop("far.glb", folder());
  const Vector3d pushed = mean_move(near, none, 0);
  EXPECT_LT(pushed.z(), -3e-4) << "m";
  // The cage differs, and so does the depth below its surface.
  EXPECT_LT((mean_move(both, none, 0) - pushed).norm(), 0.25 * pushed.norm());
}

// So does a mesh of few corners with a clip; here it keeps its place.
TEST_F(Props, AThingWithAClipPushes) {
  write(folder() / "far.glb", boxes({{{3.0, 0.0, 3.0}, {3.5, 0.5, 3.5}}}));
  write(folder() / "still.glb", boxes({beside_arm}));
  GltfBuilder b = boxes({beside_arm});
  const std::size_t times = b.add("SCALAR", std::vector<float>{0.0f, 1.0f}, {{"min", {0}}, {"max", {1}}});
  const std::size_t turns = b.add("VEC4", std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1});
  b.document["animations"] = {
      {{"samplers", {{{"input", times}, {"output", turns}}}},
       {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "rotation"}}}}}}}};
  write(folder() / "clip.glb", b);
  const std::string coarse = "[body]\nresolution = \"1500\"\n";
  const Walk still = beside_prop("still.glb", folder(), coarse),
             moved = beside_prop("clip.glb", folder(), coarse),
             none = beside_prop("far.glb", folder(), coarse);
  const Vector3d pushed = mean_move(still, none, 0);
  EXPECT_LT(pushed.z(), -3e-4) << "m";
  // A clip from a file is smoothed, and the acceleration that the arm's flesh feels is limited.
  EXPECT_LT((mean_move(moved, none, 0) - pushed).norm(), 0.1 * pushed.norm());
}

// contact.self is about a character's own flesh. Contact with other characters needs no key.
TEST_F(Props, PushWhereFleshDoesNotMeetItself) {
  write_box(folder() / "box.obj", beside_arm.low, beside_arm.high);
  const auto beside = [&](const std::string& contact) {
    return walk(arm("character.a") + "[character.b]\nrigid = true\nresolution = 0.05\nfile = \"box.obj\"\n" +
                    "[motion]\npreroll = 0.0\n" + contact + flesh_on_bones,
                6, folder());
  };
  const Walk self = beside("[contact]\nself = true\n"), others = beside(""),
             none = beside("[contact]\n" + does_not_meet);
  EXPECT_FALSE(none.model.has_contact());
  const Vector3d pushed = mean_move(self, none, 0);
  EXPECT_LT(pushed.z(), -3e-4) << "m";
  // A straight arm's flesh hardly touches itself.
  EXPECT_LT((mean_move(others, none, 0) - pushed).norm(), 0.05 * pushed.norm());

  const std::uint32_t first = others.scene.characters.at(1).first_joint;
  const auto is_of_box = [&](std::uint32_t i) {
    return others.model.skin_joint[others.model.skin_offset[i]] >= first;
  };
  std::size_t of_either[2] = {0, 0};
  for (std::uint32_t p = 0; p < others.model.contact.size(); ++p)
    for (std::uint32_t t = 0; t < others.model.contact_tetrahedron_count(); ++t) {
      const bool point = is_of_box(others.model.contact[p].vertex),
                 flesh = is_of_box(others.model.contact_tetrahedron[4 * std::size_t{t}]);
      ASSERT_EQ(others.model.is_ignored_contact(p, t), point == flesh);
      ++of_either[flesh ? 1 : 0];
    }
  EXPECT_GT(of_either[0], 0u);
  EXPECT_GT(of_either[1], 0u);
  EXPECT_TRUE(self.model.contact_group.empty()) << "no groups are needed if all flesh meets";
}

// Flesh keeps a distance of `thickness` from a prop: the prop pushes like a larger one, but looks unchanged.
TEST_F(Props, HaveAThickness) {
  const double thickness = 0.03125;
  write_box(folder() / "larger.obj", beside_arm.low, beside_arm.high);
  const Vector3d by = Vector3d::Constant(thickness);
  write_box(folder() / "box.obj", beside_arm.low + by, beside_arm.high - by);
  write_box(folder() / "far.obj", {3.0, 0.0, 3.0}, {3.5, 0.5, 3.5});
  const std::string fine = "resolution = 0.05\n", thick = "thickness = 0.03125\n" + fine;
  const Walk larger = beside_prop("larger.obj", folder()), bare = beside_prop("box.obj", folder()),
             with = beside_prop("box.obj", folder(), thick), none = beside_prop("far.obj", folder());
  const Vector3d pushed = mean_move(larger, none, 0);
  EXPECT_LT(pushed.z(), -3e-4) << "m";
  EXPECT_LT(mean_move(bare, none, 0).norm(), 0.25 * pushed.norm());
  // Edges and corners are rounded, and the cage differs.
  EXPECT_LT((mean_move(with, none, 0) - pushed).norm(), 0.25 * pushed.norm());
  // The visible skin is the box itself; floats of positions up to 2 m.
  const rig::SurfacePart& prop = std::get<rig::Character>(with.scene.geometry).parts.at(1);
  for (unsigned c = 0; c < 8; ++c)
    EXPECT_LT(
        (with.surface.back()[prop.first_vertex + c] - corner_of(beside_arm.low + by, beside_arm.high - by, c))
            .norm(),
        1e-6);
}

// A prop thinner than its tetrahedra has no depth to push with. A warning says how fine it must be, and that
// resolution does work.
TEST_F(Props, ThinOnesAreWarnedOf) {
  write_box(folder() / "plate.obj", {0, 0, 0}, {0.125, 0.02, 0.125});
  write_box(folder() / "rod.obj", {0, 0, 0}, {0.02, 0.25, 0.02});
  write_box(folder() / "cube.obj", {0, 0, 0}, {0.125, 0.125, 0.125});
  const auto warning_of = [&](const std::string& file, const std::string& resolution) {
    const scene::Scene scene = scene::parse_scene(
        {"test", "test.toml",
         arm("character.a") + "[character.b]\nrigid = true\nat = [0, 0, 3]\nresolution = " + resolution +
             "\nfile = \"" + file + "\"\n" + flesh_on_bones,
         folder()},
        {});
    build::BuildOptions options;
    options.mesher = FASCICLE_MESHER;
    build::Report report;
    build::build_model(scene, report, options);
    for (const build::Warning& warning : report.warnings)
      if (warning.text.find("no vertex inside") != std::string::npos) return warning.text;
    return std::string();
  };
  EXPECT_EQ(warning_of("cube.obj", "0.05"), "");
  for (const char* file : {"plate.obj", "rod.obj"}) {
    const std::string warning = warning_of(file, "0.03");
    ASSERT_EQ(warning.find("b: "), 0u) << warning;
    const std::string before = "`resolution` of ", after = " m or less";
    const std::size_t from = warning.find(before) + before.size(), to = warning.find(after);
    ASSERT_LT(from, to) << warning;
    EXPECT_EQ(warning_of(file, warning.substr(from, to - from)), "") << warning;
  }
}

// A prop in a hand that is bent in the bind pose follows the hand's flesh, from frame 0 on: in the bind pose
// it is `at` from the joint, rotated by `turn` in the axes of the file.
TEST_F(Props, AHeldOneGoesWithItsJoint) {
  constexpr std::uint64_t frames = 60;
  const Vector3d low(-0.1, -0.02, -0.02), high(0.5, 0.02, 0.02), at(0.02, 0.03, 0.01), turn(0, 20, 50);
  write_box(folder() / "sword.obj", low, high);
  const Walk held = walk(
      "[character.man]\nmade = \"arm-bent\"\nresolution = 0.03\nat = [0.5, 1, 0]\nturn = [0, 90, 0]\n"
      "[character.sword]\nfile = \"sword.obj\"\nrigid = true\nresolution = 0.02\njoint = \"man/hand\"\n"
      "at = [0.02, 0.03, 0.01]\nturn = [0, 20, 50]\n" +
          flesh_on_bones,
      frames, folder());
  drive::DriveSource drives(held.scene, held.model);
  const auto& character = std::get<rig::Character>(held.scene.geometry);
  const std::size_t hand = *held.scene.characters.at(1).bearer;
  const rig::Joint& joint = held.scene.characters[0].own.skeleton.at(hand - 1);
  ASSERT_EQ(joint.name, "man/hand");
  const Vector3d joint_place = joint.inverse_bind.inverse().topRightCorner<3, 1>();
  const rig::SurfacePart& prop = character.parts.at(1);
  double moved = 0.0;
  for (std::uint64_t k = 0; k <= frames; ++k) {
    const Matrix4d carried = drives.joints(k)[hand] * joint.inverse_bind;
    for (unsigned c = 0; c < 8; ++c) {
      const Vector3d expected =
          image(carried, joint_place + at + scene::turned_by(turn) * corner_of(low, high, c));
      const Vector3d& found = held.surface[k][prop.first_vertex + c];
      // Floats of positions up to 4 m, including the bind pose beside the arm, in the solver and in the
      // joints' maps.
      EXPECT_LT((found - expected).norm(), 4.0 * 4.8e-7) << k;
      moved = std::max(moved, (found - held.surface[0][prop.first_vertex + c]).norm());
    }
  }
  EXPECT_GT(moved, 0.1) << "m";
}

// Also while the preroll blends from the bind pose to the first pose.
TEST_F(Props, AHeldOneKeepsToItsJointInThePreroll) {
  write_box(folder() / "sword.obj", {-0.1, -0.02, -0.02}, {0.5, 0.02, 0.02});
  const scene::Scene scene = scene::parse_scene(
      {"test", "test.toml",
       "[scene]\nstart = 1.5\n" + arm("character.man", "at = [0.5, 1, 0]\nturn = [0, 90, 0]\n") +
           "[character.sword]\nfile = \"sword.obj\"\nrigid = true\njoint = \"man/hand\"\n"
           "at = [0.02, 0.03, 0.01]\n[character.gem]\nmade = \"arm\"\njoint = \"sword/mesh\"\n" +
           flesh_on_bones,
       folder()},
      {});
  const auto& character = std::get<rig::Character>(scene.geometry);
  drive::Timeline timeline(scene, character, std::vector<double>(3, 1.0), 1);
  const auto relative = [&](const drive::Pose& pose, std::size_t k) {
    const scene::PlacedCharacter& one = scene.characters.at(k);
    return Matrix4d(pose[*one.bearer].inverse() * pose[one.first_joint]);
  };
  const drive::Pose first = timeline.pose(0);
  double moved = 0.0;
  for (const double share : {0.0, 0.25, 0.5, 1.0}) {
    const drive::Pose pose = timeline.preroll_pose(share);
    // Doubles of lengths up to 2 m, about ten products deep.
    for (const std::size_t k : {std::size_t{1}, std::size_t{2}})
      EXPECT_LT((relative(pose, k) - relative(first, k)).norm(), 1e-13) << share;
    const std::size_t sword = scene.characters[1].first_joint;
    EXPECT_LT((pose[sword].inverse() * pose[sword + 1] - Matrix4d::Identity()).norm(), 1e-13)
        << "a joint without motion of its own stays";
    moved = std::max(moved, (pose[sword] - first[sword]).norm());
  }
  EXPECT_GT(moved, 0.1);
}

// A prop held by a still joint pushes like a free one at the same place.
TEST_F(Props, OneThatIsHeldStillPushesAsAFreeOne) {
  constexpr std::uint64_t frames = 6;
  write_box(folder() / "box.obj", {0.05, -0.15, 0.04}, {0.45, 0.15, 0.34});
  const auto beside = [&](const std::string& more) {
    return walk(arm("character.a") + "[character.b]\nresolution = 0.05\nrigid = true\nfile = \"box.obj\"\n" +
                    more + "[motion]\npreroll = 0.0\n[contact]\n" + meets + flesh_on_bones,
                frames, folder());
  };
  // The arm's shoulder is 60 mm before the origin and does not move.
  const Walk free = beside(""), held = beside("joint = \"a/shoulder\"\nat = [0.06, 0, 0]\n"),
             elsewhere = beside("at = [0, 0, 1]\n");
  const Vector3d pushed = mean_move(free, elsewhere, 0);
  EXPECT_LT(pushed.z(), -3e-4) << "m";
  // The frame's origin differs, and so does rounding; contacts may begin a substep earlier or later.
  EXPECT_LT((mean_move(held, elsewhere, 0) - pushed).norm(), 0.02 * pushed.norm());
}

// A root that moves further than its body's extent in one frame has jumped, which carries all flesh along. A
// held prop is small and fast, but does not jump.
TEST_F(Props, AHeldOneDoesNotJump) {
  write_box(folder() / "ring.obj", {-0.002, -0.002, -0.002}, {0.002, 0.002, 0.002});
  const scene::Scene scene = scene::parse_scene(
      {"test", "test.toml",
       "[scene]\nfps = 24\n" + arm("character.man") +
           "[character.ring]\nfile = \"ring.obj\"\nrigid = true\njoint = \"man/hand\"\n" + flesh_on_bones,
       folder()},
      {});
  const std::vector<double> extents{0.7, 0.004};
  drive::Timeline timeline(scene, std::get<rig::Character>(scene.geometry), extents, 1);
  double furthest = 0.0;
  const std::size_t ring = scene.characters.at(1).first_joint;
  for (std::uint64_t k = 1; k <= 48; ++k) {
    const Vector3d before = timeline.pose(k - 1)[ring].topRightCorner<3, 1>();
    furthest = std::max(furthest, (timeline.pose(k)[ring].topRightCorner<3, 1>() - before).norm());
    EXPECT_FALSE(timeline.is_cut(k)) << k;
  }
  EXPECT_GT(furthest, extents[1]) << "m per frame: the ring is too slow for this test";
  // The held prop does not shift the frame's origin either.
  const drive::Pose& pose = timeline.pose(0);
  EXPECT_EQ(timeline.root(pose), Vector3d(pose[1].topRightCorner<3, 1>()));
}

}  // namespace

}  // namespace fascicle::tests::props_test
