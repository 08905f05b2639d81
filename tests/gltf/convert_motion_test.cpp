// Characters in other formats: their shape, clips and blend shapes compared with Blender, which writes one
// character as glTF, FBX and Collada, and with the formula of FBX's transforms; and damaged files of
// Blender's.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "host/base/errors.h"
#include "host/gltf/gltf.h"
#include "host/gltf/gltf_rig.h"
#include "host/rig/character.h"
#include "host/rig/pose.h"
#include "tests/gltf/convert_files.h"
#include "tests/gltf/gltf_builder.h"
#include "tests/support/readers.h"
#include "tests/support/seed.h"

namespace fascicle::tests {
namespace {

using Eigen::Vector3d;
using rig::Character;
namespace fs = std::filesystem;

double height(const std::vector<Vector3d>& points) {
  double low = points.front().y(), high = low;
  for (const Vector3d& p : points) {
    low = std::min(low, p.y());
    high = std::max(high, p.y());
  }
  return high - low;
}

class FromBlender : public testing::Test {
 protected:
  void SetUp() override {
    FASCICLE_NEEDS_BLENDER;
    const std::string command = std::string(
                                    "blender --background --factory-startup --python-exit-code 1 "
                                    "--python '") +
                                FASCICLE_SOURCE_DIR + "/tests/readers/export_blender.py' -- '" +
                                folder_.path().string() + "' > '" + (folder_.path() / "log").string() +
                                "' 2>&1";
    ASSERT_EQ(std::system(command.c_str()), 0) << text_of(folder_.path() / "log");
  }
  Character read(const std::string& name) const { return gltf::read_gltf(folder_.path() / name); }

  TemporaryFolder folder_;
};

TEST_F(FromBlender, one_character_is_the_same_in_three_formats) {
  const Character glb = read("post.glb");
  const rig::Clip* const bend = rig::find_clip(glb, "bend");
  for (const std::string name : {"post.fbx", "post.dae"}) {
    const Character other = read(name);
    EXPECT_TRUE(other.notes.empty()) << name << ": " << other.notes.front();
    EXPECT_NEAR(height(other.surface.vertices), 1.8, file_rounding) << name << ": not in metres";
    EXPECT_EQ(other.surface.triangles.size(), glb.surface.triangles.size()) << name;
    for (const char* joint : {"lower", "upper"}) EXPECT_TRUE(has_joint(other, joint)) << name << ' ' << joint;
    ASSERT_EQ(other.clips.size(), 1u) << name;
    EXPECT_NEAR(other.clips[0].duration, bend->duration, file_rounding) << name;
    EXPECT_LT(both_ways(skinned(other, nullptr, 0.0), skinned(glb, nullptr, 0.0)), file_rounding)
        << name << ": the file was saved in the middle of the clip, which is its rest pose";
    double largest = 0.0, moved = 0.0;
    for (int frame = 0; frame <= 24; ++frame) {
      const std::vector<Vector3d> wanted = skinned(glb, bend, frame / 24.0);
      largest = std::max(largest, both_ways(skinned(other, &other.clips[0], frame / 24.0), wanted));
      moved = std::max(moved, both_ways(skinned(other, nullptr, 0.0), wanted));
    }
    EXPECT_LT(largest, file_rounding) << name;
    EXPECT_GT(moved, 0.3) << name << ": the clip moves nothing, so the comparison is meaningless";
  }
  EXPECT_EQ(read("post.fbx").clips[0].name, "Rig|bend");
}

// The largest displacement by blend shapes at a time, m.
double most_shaped(const gltf::Rig& rig, const std::string& clip, double time) {
  double largest = 0.0;
  for (const gltf::RigPart& part : rig.parts) {
    const std::vector<Vector3d> shaped =
        gltf::shaped_positions(part, rig::find_clip(rig.character, clip), time);
    for (std::size_t v = 0; v < shaped.size(); ++v)
      largest = std::max(largest, (shaped[v] - part.positions[v]).norm());
  }
  return largest;
}

TEST_F(FromBlender, blend_shapes_come_with_their_clips) {
  const gltf::Rig glb = gltf::read_rig(folder_.path() / "post.glb"),
                  fbx = gltf::read_rig(folder_.path() / "post.fbx");
  ASSERT_EQ(fbx.parts.size(), 1u);
  EXPECT_EQ(fbx.parts[0].shapes.size(), 1u);
  for (int frame = 0; frame <= 24; frame += 6) {
    const double wanted = most_shaped(glb, "swell", frame / 24.0);
    EXPECT_NEAR(most_shaped(fbx, "Rig|bend", frame / 24.0), wanted, file_rounding) << frame;
    EXPECT_NEAR(wanted, 0.075 * frame / 24.0, file_rounding) << frame;
  }
}

// As above, with a binary file: assimp passes on the keys of shapes after the stop.
TEST_F(FromBlender, blend_shapes_end_where_their_stack_does) {
  std::string text = text_of(folder_.path() / "post.fbx");
  const auto bytes_of = [](std::int64_t ticks) {
    std::string bytes(sizeof ticks, '\0');
    std::memcpy(bytes.data(), &ticks, sizeof ticks);
    return "L" + bytes;
  };
  constexpr std::int64_t second = 46186158000;
  std::size_t halved = 0;
  for (std::size_t at = text.find("LocalStop"); at != std::string::npos; at = text.find("LocalStop", at + 1))
    if (const std::size_t number = text.find(bytes_of(second), at); number < at + 40) {
      text.replace(number, 9, bytes_of(second / 2));
      ++halved;
    }
  ASSERT_GT(halved, 0u);
  const gltf::Rig rig = gltf::read_rig(folder_.write("half.fbx", text));
  EXPECT_NEAR(rig::find_clip(rig.character, "Rig|bend")->duration, 0.5, file_rounding);
  EXPECT_NEAR(most_shaped(rig, "Rig|bend", 0.5), 0.0375, file_rounding);
}

TEST_F(FromBlender, cut_off_and_damaged_files_are_refused_or_read) {
  std::mt19937_64 random(seed_of_run(7));
  for (const std::string name : {"post.fbx", "post.dae"}) {
    const std::string whole = text_of(folder_.path() / name);
    for (const std::size_t part : {1u, 2u, 3u}) {
      const fs::path cut = folder_.write("cut-" + name, whole.substr(0, whole.size() * part / 4));
      try {
        gltf::read_gltf(cut);
        FAIL() << name << " was read with " << part << " quarters of it";
      } catch (const base::SceneError& error) {
        const std::string what = error.what();
        EXPECT_EQ(what.find(cut.string() + ": "), 0u) << what;
        EXPECT_NE(what.find("export `cut-post.glb`"), std::string::npos) << what;
        EXPECT_EQ(what.find('\n'), std::string::npos) << what;
      }
    }
    // Anything but an error or a character fails this test too.
    for (int i = 0; i < 12; ++i) {
      std::string damaged = whole;
      for (int k = 0; k < 20; ++k) damaged[random() % damaged.size()] = static_cast<char>(random() % 256);
      try {
        gltf::read_gltf(folder_.write("damaged-" + name, damaged));
      } catch (const base::SceneError&) {
      }
    }
  }
}

constexpr double degree = 3.14159265358979323846 / 180.0;

Eigen::Affine3d turned(double x, double y, double z) {
  return Eigen::Affine3d(Eigen::AngleAxisd(z * degree, Vector3d::UnitZ()) *
                         Eigen::AngleAxisd(y * degree, Vector3d::UnitY()) *
                         Eigen::AngleAxisd(x * degree, Vector3d::UnitX()));
}
Eigen::Affine3d moved(double x, double y, double z) {
  return Eigen::Affine3d(Eigen::Translation3d(x, y, z));
}

const std::vector<Vector3d> plate{{0, 0, 0}, {10, 0, 0}, {0, 20, 0}, {0, 0, 30}};

// `local` gives the transform at an angle, in the file's axes and unit; `world` converts those to metres.
template <typename Local>
void expect_motion(const std::string& text, const Eigen::Matrix3d& world, const Local& local) {
  const TemporaryFolder folder;
  const Character character = gltf::read_gltf(folder.write("plate.fbx", text));
  ASSERT_EQ(character.clips.size(), 1u);
  EXPECT_EQ(character.clips[0].name, "turn");
  EXPECT_NEAR(character.clips[0].duration, 1.0, 1e-6);
  for (const double time : {0.0, 0.5, 1.0}) {
    std::vector<Vector3d> wanted;
    for (const Vector3d& p : plate) wanted.push_back(world * (local(90.0 * time) * p));
    EXPECT_LT(both_ways(skinned(character, &character.clips[0], time), wanted),
              file_rounding * world.norm() * 30.0)
        << "at " << time << " s";
  }
}

TEST(Fbx, axes_and_unit_become_metres_with_y_up) {
  // 3ds Max: Z up, inches.
  Post post{.properties = property("Lcl Translation", 1, 2, 3), .up = 2, .unit = 2.54};
  Eigen::Matrix3d world;
  world << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  expect_motion(fbx_of(post), 0.0254 * world,
                [](double angle) { return moved(1, 2, 3) * turned(0, 0, angle); });
  // Control: in centimetres, the usual unit, the plate would be elsewhere.
  const Eigen::Matrix3d inches = 0.0254 * world;
  std::vector<Vector3d> in_inches;
  for (const Vector3d& p : plate) in_inches.push_back(inches * (moved(1, 2, 3) * p));
  post.unit = 1.0;
  const TemporaryFolder folder;
  const Character smaller = gltf::read_gltf(folder.write("plate.fbx", fbx_of(post)));
  EXPECT_GT(both_ways(skinned(smaller, &smaller.clips.at(0), 0.0), in_inches), 0.01 * inches.norm());
}

TEST(Fbx, rotations_before_and_after_the_nodes_own_are_kept) {
  const Post post{.properties = property("Lcl Translation", 1, 2, 3) + property("PreRotation", 90, 20, 0) +
                                property("PostRotation", 0, 30, 10)};
  expect_motion(fbx_of(post), 0.01 * Eigen::Matrix3d::Identity(), [](double angle) {
    return moved(1, 2, 3) * turned(90, 20, 0) * turned(0, 0, angle) * turned(0, 30, 10).inverse();
  });
}

TEST(Fbx, nodes_turn_about_their_pivots) {
  const Post post{.properties = property("Lcl Translation", 1, 2, 3) + property("RotationOffset", 4, 0, 0) +
                                property("RotationPivot", 0, 50, 0) + property("PreRotation", 0, 0, 40) +
                                property("ScalingOffset", 0, 0, 7) + property("ScalingPivot", 5, 5, 5) +
                                property("Lcl Scaling", 2, 2, 2)};
  expect_motion(fbx_of(post), 0.01 * Eigen::Matrix3d::Identity(), [](double angle) {
    return moved(1, 2, 3) * moved(4, 0, 0) * moved(0, 50, 0) * turned(0, 0, 40) * turned(0, 0, angle) *
           moved(0, -50, 0) * moved(0, 0, 7) * moved(5, 5, 5) * Eigen::Scaling(2.0) * moved(-5, -5, -5);
  });
}

// Constant channels are dropped, but they still extend the clip.
TEST(Converter, clips_last_to_their_last_key) {
  const TemporaryFolder folder;
  const Character held = gltf::read_gltf(folder.write("held.fbx", fbx_of({.has_still = true})));
  ASSERT_EQ(held.clips.size(), 1u);
  EXPECT_NEAR(held.clips[0].duration, 2.0, 1e-6);
  for (const rig::Channel& channel : held.clips[0].channels)
    EXPECT_EQ(held.skeleton[channel.joint].name, "Arm") << "the plate stands still";
  EXPECT_LT(both_ways(skinned(held, &held.clips[0], 2.0), skinned(held, &held.clips[0], 1.0)), file_rounding);

  const Character still = gltf::read_gltf(folder.write("still.dae", dae_of("top", "bone")));
  ASSERT_EQ(still.clips.size(), 1u);
  EXPECT_NEAR(still.clips[0].duration, 2.0, 1e-6);
  EXPECT_LT(both_ways(skinned(still, &still.clips[0], 1.0), skinned(still, nullptr, 0.0)), file_rounding);
}

// The angle by which the plate is turned about Z, in degrees.
double angle_at(const Character& character, double time) {
  const std::vector<Vector3d> still = skinned(character, nullptr, 0.0),
                              now = skinned(character, &character.clips.at(0), time);
  std::size_t far = 0;
  for (std::size_t v = 0; v < still.size(); ++v)
    if (still[v].x() > still[far].x()) far = v;
  return std::atan2(now[far].y(), now[far].x()) / degree;
}

// Single precision through quaternions, degrees.
constexpr double angle_rounding = 1e-3;

// Assimp passes on the first key of a rotation even if it is outside.
TEST(Fbx, a_rotations_first_key_outside_its_stack_counts_up_to_the_border) {
  const TemporaryFolder folder;
  const auto read = [&](const Keys& turns) {
    return gltf::read_gltf(folder.write("plate.fbx", fbx_of({.stack = span(1.0, 2.0), .turns = turns})));
  };
  const Character held = read({{0.0, 45.0}});
  ASSERT_EQ(held.clips.size(), 1u);
  EXPECT_NEAR(angle_at(held, 0.0), 45.0, angle_rounding);
  const Character cut = read({{0.0, 0.0}, {1.5, 90.0}});
  ASSERT_EQ(cut.clips.size(), 1u);
  EXPECT_NEAR(cut.clips[0].duration, 0.5, 1e-6);
  EXPECT_NEAR(angle_at(cut, 0.0), 60.0, angle_rounding);
  EXPECT_NEAR(angle_at(cut, 0.25), 75.0, angle_rounding);
  EXPECT_NEAR(angle_at(cut, 0.5), 90.0, angle_rounding);
  const Character late = read({{3.0, 45.0}});
  ASSERT_EQ(late.clips.size(), 1u);
  EXPECT_LE(late.clips[0].duration, 1.0 + 1e-6);
  EXPECT_NEAR(angle_at(late, 1.0), 45.0, angle_rounding);
  // Control: keys at the borders are taken as they are.
  const Character whole = read({{1.0, 10.0}, {2.0, 20.0}});
  EXPECT_NEAR(angle_at(whole, 0.0), 10.0, angle_rounding);
  EXPECT_NEAR(whole.clips.at(0).duration, 1.0, 1e-6);
}

// Shapes are in the file's unit, cm.
constexpr double shape_rounding = 100.0 * file_rounding;

TEST(Fbx, blend_shapes_last_as_long_as_their_stack) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& text) { return gltf::read_rig(folder.write("plate.fbx", text)); };
  const Keys turns{{1.0, 0.0}, {2.0, 90.0}}, shapes{{0.0, 0.0}, {4.0, 100.0}};
  const gltf::Rig cut = read(fbx_of({.stack = span(1.0, 2.0), .turns = turns, .shapes = shapes}));
  ASSERT_EQ(cut.character.clips.size(), 1u);
  EXPECT_NEAR(cut.character.clips[0].duration, 1.0, 1e-6);
  EXPECT_NEAR(most_shaped(cut, "turn", 0.0), 2.5, shape_rounding);
  EXPECT_NEAR(most_shaped(cut, "turn", 1.0), 5.0, shape_rounding);

  // A stack without start and stop lasts to the last key of nodes or shapes, also if it says so with zeros.
  for (const std::string& none : {std::string(), span(0.0, 0.0)}) {
    const gltf::Rig all = read(fbx_of({.stack = none, .turns = turns, .shapes = {{1.0, 0.0}, {4.0, 100.0}}}));
    EXPECT_NEAR(all.character.clips.at(0).duration, 3.0, 1e-6);
    EXPECT_NEAR(most_shaped(all, "turn", 3.0), 10.0, shape_rounding);
  }
}

TEST(Fbx, a_clip_of_blend_shapes_alone_begins_at_its_first_key) {
  const TemporaryFolder folder;
  std::string text = fbx_of({.shapes = {{1.0, 0.0}, {3.0, 100.0}}});
  replace(
      text, "AnimationCurveNode: 43",
      "AnimationStack: 50, \"AnimStack::swell\", \"\" {\n}\nAnimationLayer: 51, \"AnimLayer::base\", \"\" "
      "{\n}\nAnimationCurveNode: 43");
  replace(text, "C: \"OO\",43,21", "C: \"OO\",43,51\nC: \"OO\",51,50");
  const gltf::Rig rig = gltf::read_rig(folder.write("plate.fbx", text));
  ASSERT_EQ(rig.character.clips.size(), 2u);
  // Assimp shifts its times by 10^10 frames, which leaves 2e-6 of a frame.
  EXPECT_NEAR(rig::find_clip(rig.character, "swell")->duration, 2.0, 1e-6);
  EXPECT_NEAR(most_shaped(rig, "swell", 0.0), 0.0, shape_rounding);
  EXPECT_NEAR(most_shaped(rig, "swell", 1.0), 5.0, shape_rounding);
}

}  // namespace
}  // namespace fascicle::tests
