// character.NAME.joint: a character attached to a joint of another one.
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "host/made/made_character.h"
#include "host/rig/pose.h"
#include "host/scene/solids.h"
#include "tests/scene/scene_texts.h"
#include "tests/support/assets.h"

namespace fascicle::tests::bearers_test {
namespace {

using namespace scene;

const std::string layers = "[layers.body]\nalpha = 0.5\n";
const std::string man = "[character.man]\nmade = \"arm-bent\"\nat = [0.5, 1.0, 2.0]\nturn = [0, 90, 0]\n";

std::string held(const std::string& name, const std::string& joint, const std::string& more = "") {
  return "[character." + name + "]\nmade = \"arm\"\njoint = \"" + joint + "\"\n" + more;
}

const rig::Character& all_of(const Scene& scene) {
  return std::get<rig::Character>(scene.geometry);
}

std::uint32_t joint_called(const Scene& scene, const std::string& name) {
  const std::vector<rig::Joint>& skeleton = all_of(scene).skeleton;
  std::uint32_t j = 0;
  while (skeleton.at(j).name != name) ++j;
  return j;
}

// Products of about ten double matrices, with lengths up to 3 m.
constexpr double rounding = 1e-13;

// A held character is carried like the flesh at that joint: by the map from the bind pose to the pose. In the
// bind pose it is `at` from the joint, rotated by `turn` in the axes of the bearer's file.
void expect_held(const Scene& scene, const std::string& joint, const Vector3d& at, const Vector3d& turn) {
  const rig::Character& all = all_of(scene);
  const rig::Clip* clip = all.clips.empty() ? nullptr : &all.clips[0];
  const PlacedCharacter& bearer = scene.characters.at(0);
  const PlacedCharacter& prop = scene.characters.at(1);
  const std::uint32_t number = joint_called(scene, joint);
  const rig::Joint& own = bearer.own.skeleton.at(number - bearer.first_joint - 1);
  Eigen::Matrix4d stands = Eigen::Matrix4d::Identity();
  stands.topLeftCorner<3, 3>() = turned_by(turn);
  stands.topRightCorner<3, 1>() = own.inverse_bind.inverse().topRightCorner<3, 1>() + at;
  for (const double time : {0.0, 0.5, 1.25}) {
    const auto pose = rig::joint_transforms_at(all, clip, time);
    // From the bearer's own bind pose to the pose of its flesh.
    const Eigen::Matrix4d carried = pose[number] * own.inverse_bind;
    const auto alone = rig::joint_transforms_at(
        prop.own, prop.own.clips.empty() ? nullptr : &prop.own.clips[0], time - prop.settings.start);
    for (std::size_t j = 0; j < alone.size(); ++j)
      EXPECT_LT((pose[prop.first_joint + 1 + j] - carried * stands * alone[j]).norm(), rounding) << time;
  }
}

TEST(Bearers, AHeldCharacterGoesWithTheJoint) {
  const Scene scene = parse(
      man + held("sword", "man/hand", "at = [0.1, 0.2, 0.3]\nturn = [30, 0, 60]\nstart = 0.25\n") + layers);
  ASSERT_EQ(scene.characters.at(1).bearer, joint_called(scene, "man/hand"));
  EXPECT_EQ(all_of(scene).skeleton[joint_called(scene, "sword")].parent,
            static_cast<std::int32_t>(joint_called(scene, "man/hand")));
  expect_held(scene, "man/hand", {0.1, 0.2, 0.3}, {30, 0, 60});
}

// Joints in files may be rotated and scaled in their bind pose; the held character is not.
TEST(Bearers, TheJointsOwnAxesDoNotMatter) {
  const std::filesystem::path file = asset("CesiumMan.glb");
  FASCICLE_NEEDS_ASSET(file);
  const std::string joint = "man/Skeleton_arm_joint_R";
  const Scene scene = parse("[character.man]\nfile = \"CesiumMan.glb\"\nat = [0.5, 1.0, 2.0]\n" +
                                held("sword", joint, "at = [0.1, 0.2, 0.3]\nturn = [0, 40, 0]\n") + layers,
                            {}, file.parent_path());
  const Eigen::Matrix3d axes =
      all_of(scene).skeleton[joint_called(scene, joint)].inverse_bind.topLeftCorner<3, 3>();
  EXPECT_GT((axes - Eigen::Matrix3d::Identity()).norm(), 0.1) << "otherwise this test is meaningless";
  expect_held(scene, joint, {0.1, 0.2, 0.3}, {0, 40, 0});
}

// A character's top joint is the character's placement.
TEST(Bearers, ACharacterItselfBears) {
  const Scene scene = parse(man + held("pack", "man", "at = [0.1, 0, 0]\n") + layers);
  const auto pose = rig::joint_transforms_at(all_of(scene), nullptr, 0.0);
  const Vector3d expected = Vector3d(0.5, 1.0, 2.0) + turned_by({0, 90, 0}) * Vector3d(0.1, 0, 0);
  EXPECT_LT((pose[joint_called(scene, "pack")].topRightCorner<3, 1>() - expected).norm(), rounding);
}

TEST(Bearers, ComeFirst) {
  const Scene scene = parse(held("gem", "sword/hand") + held("sword", "man/hand") + man +
                            "[character.other]\nmade = \"arm\"\n" + layers);
  std::vector<std::string> names;
  for (const PlacedCharacter& one : scene.characters) names.push_back(one.settings.name);
  EXPECT_EQ(names, (std::vector<std::string>{"man", "sword", "gem", "other"}));
  const std::vector<rig::Joint>& skeleton = all_of(scene).skeleton;
  for (std::size_t j = 0; j < skeleton.size(); ++j)
    ASSERT_LT(skeleton[j].parent, static_cast<std::int32_t>(j)) << skeleton[j].name;
}

TEST(Bearers, AreSetByTheirKey) {
  const std::string free = man + "[character.sword]\nmade = \"arm\"\n" + layers;
  EXPECT_FALSE(parse(free).characters.at(1).bearer);
  const Scene scene = parse(free, {.set = {"character.sword.joint=man/hand"}});
  EXPECT_EQ(scene.characters.at(1).bearer, joint_called(scene, "man/hand"));
}

TEST(Bearers, RefuseWhatCannotBe) {
  EXPECT_EQ(refusal_of_text(man + held("sword", "man/hnd") + layers),
            "sample.toml:7: character.sword.joint: no other character has a joint \"man/hnd\"; did you mean "
            "man/hand?");
  EXPECT_EQ(refusal_of_text(man + held("sword", "hand") + layers),
            "sample.toml:7: character.sword.joint: no other character has a joint \"hand\"; did you mean "
            "man/hand?");
  EXPECT_EQ(refusal_of_text(man + held("sword", "sword/hand") + layers),
            "sample.toml:7: character.sword.joint: \"sword/hand\" is one of its own joints; name one of "
            "another character");
  EXPECT_EQ(refusal_of_text(held("a", "b/hand") + held("b", "a/hand") + layers),
            "sample.toml:3: character.a.joint: the characters that it is attached to are attached to each "
            "other in a cycle; remove one `joint`");
  EXPECT_EQ(refusal_of_text("[character]\nmade = \"arm\"\njoint = \"hand\"\n" + layers),
            "sample.toml:3: character.joint: unknown; known here: file, made, paint, clip, resolution");
}

}  // namespace
}  // namespace fascicle::tests::bearers_test
