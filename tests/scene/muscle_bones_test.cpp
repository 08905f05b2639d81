// The bones that a muscle's keys refer to, on the generated arm: shoulder, upper_arm, forearm, hand, along x.
#include "host/scene/muscle_bones.h"

#include <gtest/gtest.h>

#include "host/made/made_character.h"

namespace fascicle::tests {
namespace {

using scene::Muscle;
using scene::MuscleBones;
using scene::Vector3d;

constexpr std::uint32_t shoulder = 0, upper_arm = 1, forearm = 2, hand = 3;

const rig::Character& made_arm() {
  static const rig::Character character = made::make_character("arm");
  return character;
}

std::string muscle_refusal(const Muscle& muscle) {
  try {
    scene::muscle_bones(made_arm(), muscle);
  } catch (const scene::SceneError& error) {
    return error.what();
  }
  return {};
}

TEST(MuscleBones, AJointsUpperBoneCarriesTheMuscle) {
  const MuscleBones bones = scene::muscle_bones(made_arm(), {.name = "m", .joint = "forearm"});
  ASSERT_TRUE(bones.bend.has_value());
  EXPECT_EQ(bones.bend->upper, upper_arm);
  EXPECT_EQ(bones.bend->joint, forearm);
  EXPECT_EQ(bones.bend->lower_end, hand);
  EXPECT_EQ(bones.carrier, upper_arm);
  EXPECT_EQ(bones.from, Vector3d(0.0, 0.0, 0.0));
  EXPECT_EQ(bones.to, Vector3d(0.3, 0.0, 0.0));
  EXPECT_EQ(bones.moves, (std::vector<char>{0, 1, 0, 0}));
  EXPECT_EQ(bones.twisted, forearm);
  EXPECT_EQ(bones.against, upper_arm);
}

TEST(MuscleBones, TheLowerBoneWhereItIsNamed) {
  const MuscleBones bones =
      scene::muscle_bones(made_arm(), {.name = "m", .joint = "forearm", .bone = "forearm"});
  EXPECT_EQ(bones.carrier, forearm);
  EXPECT_EQ(bones.moves, (std::vector<char>{0, 0, 1, 0}));
  EXPECT_EQ(bones.twisted, hand);
}

TEST(MuscleBones, BonesOverSeveralJoints) {
  const MuscleBones bones =
      scene::muscle_bones(made_arm(), {.name = "m", .joint = "hand", .parent = "upper_arm"});
  EXPECT_EQ(bones.from, Vector3d(0.0, 0.0, 0.0));
  EXPECT_EQ(bones.carrier, forearm) << "the last joint along the bone";
  EXPECT_EQ(bones.moves, (std::vector<char>{0, 1, 1, 0}));
  EXPECT_FALSE(bones.bend->lower_end.has_value()) << "the hand ends the chain";
  EXPECT_GT(bones.bend->tip.x(), 0.60) << "past the wrist at 0.56";
}

TEST(MuscleBones, WithoutAJointABoneAlone) {
  const MuscleBones bones =
      scene::muscle_bones(made_arm(), {.name = "m", .bone = "forearm", .twist_joint = "upper_arm"});
  EXPECT_FALSE(bones.bend.has_value());
  EXPECT_EQ(bones.to, scene::joint_place(made_arm().skeleton[hand]));
  EXPECT_EQ(bones.twisted, upper_arm);
  EXPECT_EQ(bones.against, shoulder);
}

TEST(MuscleBones, RefusesWhatDoesNotFit) {
  EXPECT_EQ(
      muscle_refusal({.name = "m", .joint = "foerarm"}),
      "muscle.m.joint: no joint is called \"foerarm\"; did you mean forearm?; `fascicle inspect` lists them");
  EXPECT_TRUE(
      muscle_refusal({.name = "m", .joint = "shoulder"}).starts_with("muscle.m.joint: above \"shoulder\""));
  EXPECT_TRUE(muscle_refusal({.name = "m", .joint = "forearm", .parent = "hand"})
                  .starts_with("muscle.m.parent: \"hand\" is not above"));
  EXPECT_TRUE(muscle_refusal({.name = "m", .joint = "forearm", .child = "upper_arm"})
                  .starts_with("muscle.m.child: \"upper_arm\" is not below"));
  EXPECT_TRUE(muscle_refusal({.name = "m", .joint = "hand", .bone = "shoulder"})
                  .starts_with("muscle.m.bone: \"shoulder\" belongs neither to"));
}

// A joint without vertices has no inverse bind matrix, and so no place in the bind pose.
TEST(MuscleBones, RefusesJointsThatSkinNothing) {
  rig::Character character = made_arm();
  character.skeleton[hand].skins = false;
  for (const Muscle& muscle : {Muscle{.name = "m", .joint = "forearm", .child = "hand"},
                               Muscle{.name = "m", .bone = "forearm", .twist_joint = "hand"}})
    EXPECT_THROW(scene::muscle_bones(character, muscle), scene::SceneError);
}

TEST(ContractionChannel, IsAJointAPartAndAnAxis) {
  const scene::ContractionChannel channel =
      scene::contraction_channel(made_arm(), {.name = "m", .contraction_channel = "hand.scale.y"});
  EXPECT_EQ(channel.joint, hand);
  EXPECT_EQ(channel.path, rig::ChannelPath::scale);
  EXPECT_EQ(channel.axis, 1u);
  for (const char* text :
       {"", "x", ".x", "hand.x", "hand.rotation.x", "hand.scale.w", "hand.scale.", "hund.scale.x"})
    EXPECT_THROW(scene::contraction_channel(made_arm(), {.name = "m", .contraction_channel = text}),
                 scene::SceneError)
        << text;
}

TEST(KeyedCurve, IsStraightBetweenKeysAndHeldBeyond) {
  const scene::KeyedCurve curve{{1.0, 2.0}, {3.0, 6.0}, {4.0, 0.0}};
  EXPECT_EQ(scene::value_at(curve, 0.0), 2.0);
  EXPECT_EQ(scene::value_at(curve, 1.0), 2.0);
  EXPECT_EQ(scene::value_at(curve, 2.0), 4.0);
  EXPECT_EQ(scene::value_at(curve, 3.5), 3.0);
  EXPECT_EQ(scene::value_at(curve, 9.0), 0.0);
  EXPECT_EQ(scene::value_at({{1.0, 5.0}}, 1.0), 5.0);
}

}  // namespace
}  // namespace fascicle::tests
