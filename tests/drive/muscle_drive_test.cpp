// Muscle inputs from poses: tau, activation, contraction and twist, for angles known by construction.
#include "host/drive/muscle_drive.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "host/made/made_character.h"
#include "host/rig/pose.h"

namespace fascicle::tests {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector3d;

constexpr double degree = std::numbers::pi / 180.0;
// Float rounding near 1.
constexpr double rounding = 1e-6;

// The generated arm: its joints are along x and the elbow bends about z, towards +y.
struct Arm {
  scene::Scene scene;
  const rig::Character& character() const { return std::get<rig::Character>(scene.geometry); }
};

Arm arm_with(const scene::Muscle& muscle, const std::string& made = "arm") {
  Arm arm;
  arm.scene.geometry = made::make_character(made);
  arm.scene.fps = 60.0;
  arm.scene.end = 4.0;
  arm.scene.muscles = {muscle};
  return arm;
}

// The arm's bind pose with the forearm turned about the elbow, the hand about the forearm's axis, and the
// whole arm about the shoulder.
drive::Pose posed(const rig::Character& arm, double elbow_degrees, double hand_radians = 0.0,
                  const Eigen::Matrix3d& whole = Eigen::Matrix3d::Identity()) {
  drive::Pose pose;
  for (const rig::Joint& joint : arm.skeleton) {
    Matrix4d m = Matrix4d::Identity();
    m.topRightCorner<3, 1>() = scene::joint_place(joint);
    pose.push_back(m);
  }
  const auto turn = [&](std::size_t from, const Eigen::Matrix3d& rotation) {
    const Vector3d at = pose[from].topRightCorner<3, 1>();
    for (std::size_t j = from; j < pose.size(); ++j) {
      pose[j].topLeftCorner<3, 3>() = (rotation * pose[j].topLeftCorner<3, 3>()).eval();
      pose[j].topRightCorner<3, 1>() =
          (at + rotation * (Vector3d(pose[j].topRightCorner<3, 1>()) - at)).eval();
    }
  };
  turn(3, Eigen::AngleAxisd(hand_radians, Vector3d::UnitX()).toRotationMatrix());
  turn(2, Eigen::AngleAxisd(elbow_degrees * degree, Vector3d::UnitZ()).toRotationMatrix());
  turn(0, whole);
  return pose;
}

shader::Muscle value_of(const Arm& arm, const drive::Pose& pose, double time = 0.0) {
  const drive::MuscleDrive drive(arm.scene, arm.character());
  std::vector<shader::Muscle> values;
  drive.append(pose, time, values);
  EXPECT_EQ(values.size(), 1u);
  return values.at(0);
}

void expect_tau(const shader::Muscle& value, const Vector3d& expected) {
  EXPECT_NEAR(value.tau_x, expected.x(), rounding);
  EXPECT_NEAR(value.tau_y, expected.y(), rounding);
  EXPECT_NEAR(value.tau_z, expected.z(), rounding);
}

TEST(MuscleDrive, ActivationRisesWithTheAngleAndTauIsTheFoldingSide) {
  const Arm arm = arm_with({.name = "m", .joint = "forearm"});
  const Eigen::Matrix3d whole(Eigen::AngleAxisd(1.1, Vector3d(1, 2, 3).normalized()));
  for (const double angle : {0.0, 3.0, 46.0, 90.0, 130.0, 160.0}) {
    const double activation = (1.0 - std::cos(angle * degree)) / 2.0;
    expect_tau(value_of(arm, posed(arm.character(), angle)), activation * Vector3d::UnitY());
    // Tau is a rest-space direction, whatever way the arm points.
    expect_tau(value_of(arm, posed(arm.character(), angle, 0.0, whole)), activation * Vector3d::UnitY());
  }
}

TEST(MuscleDrive, NothingInTheBindPoseEvenIfItIsBent) {
  const Arm arm = arm_with({.name = "m", .joint = "forearm"}, "arm-bent");
  expect_tau(value_of(arm, posed(arm.character(), 0.0)), Vector3d::Zero());
  const double bound = 46.0;
  for (const double angle : {-40.0, 44.0, 114.0}) {
    const double activation = (std::cos(bound * degree) - std::cos((bound + angle) * degree)) / 2.0;
    expect_tau(value_of(arm, posed(arm.character(), angle)), activation * Vector3d::UnitY());
  }
}

TEST(MuscleDrive, BelowFiveDegreesTheClipsHingeLeads) {
  const Arm arm = arm_with({.name = "m", .joint = "forearm"}, "arm-bent");
  // Extended 2 degrees past straight: the elbow bends the other way, which does not count yet.
  const double activation = (std::cos(46.0 * degree) - std::cos(2.0 * degree)) / 2.0;
  expect_tau(value_of(arm, posed(arm.character(), -48.0)), activation * Vector3d::UnitY());
}

// Where the bind pose is bent, a straight joint's activation is less than at rest, so tau is not small where
// it turns around. It passes through 0 within the 5 degrees between hinge and bending plane: by 0.3 in all,
// 0.006 per tenth.
TEST(MuscleDrive, PastStraightTauTurnsAroundWithoutAJump) {
  const Arm arm = arm_with({.name = "m", .joint = "forearm"}, "arm-bent");
  double before = value_of(arm, posed(arm.character(), -40.0)).tau_y;
  const double first = before;
  for (int tenth = 401; tenth <= 610; ++tenth) {
    const double now = value_of(arm, posed(arm.character(), -0.1 * tenth)).tau_y;
    ASSERT_LT(std::abs(now - before), 0.02) << tenth;
    before = now;
  }
  EXPECT_LT(first, -0.1);
  EXPECT_GT(before, 0.1);
}

TEST(MuscleDrive, FormsOfActivation) {
  const double angle = 120.0 * degree;
  const drive::Pose pose = posed(made::make_character("arm"), 120.0);
  expect_tau(
      value_of(arm_with({.name = "m", .joint = "forearm", .activation = scene::Activation::sine}), pose),
      std::sin(angle) * Vector3d::UnitY());
  expect_tau(
      value_of(arm_with({.name = "m", .joint = "forearm", .axis = scene::BulgeAxis::plane_normal}), pose),
      (1.0 - std::cos(angle)) / 2.0 * Vector3d::UnitZ());
  // 3/4 of the way from 0.25 to 1, minus the curve's 0.25 in the bind pose.
  expect_tau(
      value_of(arm_with({.name = "m", .joint = "forearm", .curve = {{0.0, 0.25}, {160.0, 1.25}}}), pose),
      0.75 * Vector3d::UnitY());
}

// On the lower bone tau is perpendicular to that bone: at 90 degrees it points back along the upper bone,
// which is +y rotated back to rest.
TEST(MuscleDrive, OnTheLowerBone) {
  const Arm arm = arm_with({.name = "m", .joint = "forearm", .bone = "forearm"});
  for (const double angle : {46.0, 90.0, 130.0})
    expect_tau(value_of(arm, posed(arm.character(), angle)),
               (1.0 - std::cos(angle * degree)) / 2.0 * Vector3d::UnitY());
}

TEST(MuscleDrive, ContractionFollowsItsCurveOrChannel) {
  const Arm keyed = arm_with({.name = "m", .bone = "forearm", .contraction = {{1.0, 0.0}, {2.0, 0.5}}});
  const drive::Pose pose = posed(keyed.character(), 50.0);
  EXPECT_EQ(value_of(keyed, pose, 0.5).swell, 0.0f);
  EXPECT_EQ(value_of(keyed, pose, 1.5).swell, 0.25f);
  expect_tau(value_of(keyed, pose, 1.5), Vector3d::Zero());
  Arm channel = arm_with({.name = "m", .bone = "forearm", .contraction_channel = "hand.scale.y"});
  EXPECT_EQ(value_of(channel, pose, 1.5).swell, 0.0f) << "the clip does not move it";
  auto& character = std::get<rig::Character>(channel.scene.geometry);
  character.clips[0].channels.push_back(
      {3, rig::ChannelPath::scale, rig::Interpolation::linear, {0.0, 2.0}, {1, 1, 1, 1, 1.5, 1}});
  EXPECT_EQ(value_of(channel, pose, 1.0).swell, 0.25f) << "its value at rest is 1";
}

TEST(MuscleDrive, TwistIsTheTurnAboutTheBone) {
  const Arm arm = arm_with({.name = "m", .bone = "forearm", .twist = 1.0});
  const Eigen::Matrix3d whole(Eigen::AngleAxisd(2.0, Vector3d(3, -1, 2).normalized()));
  for (const double turn : {-2.5, -0.7, 0.0, 0.3, 3.0})
    for (const double elbow : {0.0, 70.0})
      EXPECT_NEAR(value_of(arm, posed(arm.character(), elbow, turn, whole)).twist, turn, rounding);
  const Arm without = arm_with({.name = "m", .bone = "forearm"});
  EXPECT_EQ(value_of(without, posed(arm.character(), 0.0, 0.7)).twist, 0.0f);
}

}  // namespace
}  // namespace fascicle::tests
