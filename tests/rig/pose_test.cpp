#include "host/rig/pose.h"

#include <cmath>
#include <numbers>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "host/base/errors.h"
#include "host/rig/pose_interpolation.h"

namespace fascicle::tests {
namespace {

using Eigen::Matrix4d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::Vector4d;
using rig::Channel;
using rig::ChannelPath;
using rig::Interpolation;

// A few dozen operations on numbers near 1, each off by 1e-16.
constexpr double rounding = 1e-14;

Vector4d random_rotation(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return Vector4d(normal(random), normal(random), normal(random), normal(random)).normalized();
}

Quaterniond quaternion(const Vector4d& v) {
  return {v[3], v[0], v[1], v[2]};
}

TEST(Slerp, agrees_with_the_library) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int i = 0; i < 20000; ++i) {
    const Vector4d a = random_rotation(random), b = random_rotation(random);
    const double u = unit(random);
    const Quaterniond expected = quaternion(a).slerp(u, quaternion(b));
    const Vector4d got = rig::slerp(a, b, u);
    EXPECT_LT((got - expected.coeffs()).norm(),
              rounding * 100)  // the library divides by the sine of small angles
        << a.transpose() << " to " << b.transpose() << " at " << u;
  }
}

TEST(Slerp, turns_evenly_about_one_axis) {
  const Vector3d axis = Vector3d(1, -2, 3).normalized();
  for (const double angle : {1e-9, 1e-7, 1e-5, 0.01, 1.0, 3.0}) {
    const auto at = [&](double x) {
      Vector4d q;
      q << axis * std::sin(0.5 * x), std::cos(0.5 * x);
      return q;
    };
    for (const double u : {0.0, 0.125, 0.5, 0.9, 1.0}) {
      EXPECT_LT((rig::slerp(at(0.2), at(0.2 + angle), u) - at(0.2 + u * angle)).norm(), rounding)
          << angle << " " << u;
    }
  }
}

TEST(Slerp, takes_the_short_way_round) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 1000; ++i) {
    const Vector4d a = random_rotation(random), b = random_rotation(random);
    const Vector4d middle = rig::slerp(a, b, 0.5), other = rig::slerp(a, -b, 0.5);
    EXPECT_GE(std::abs(middle.dot(a)), std::sqrt(0.5) - rounding);
    EXPECT_LT((middle - other).norm(), rounding);
  }
}

// A cubic is its own Hermite interpolant.
TEST(Hermite, reproduces_cubics) {
  const auto value = [](double x) { return 2.0 - 3.0 * x + 0.5 * x * x - 1.5 * x * x * x; };
  const auto slope = [](double x) { return -3.0 + x - 4.5 * x * x; };
  const double from = 0.7, to = 2.2, span = to - from;
  for (int i = 0; i <= 64; ++i) {
    const double u = i / 64.0;
    EXPECT_NEAR(rig::hermite(value(from), slope(from) * span, value(to), slope(to) * span, u),
                value(from + u * span),
                rounding * 20);  // values up to 20
  }
}

TEST(Sample, step_holds_and_linear_runs_and_both_are_clamped) {
  Channel channel{
      0, ChannelPath::translation, Interpolation::step, {1.0, 2.0, 4.0}, {1, 2, 3, 5, 6, 7, 9, 8, 7}};
  EXPECT_EQ(rig::sample(channel, 0.0).head<3>(), Vector3d(1, 2, 3));
  EXPECT_EQ(rig::sample(channel, 1.999).head<3>(), Vector3d(1, 2, 3));
  EXPECT_EQ(rig::sample(channel, 2.0).head<3>(), Vector3d(5, 6, 7));
  EXPECT_EQ(rig::sample(channel, 100.0).head<3>(), Vector3d(9, 8, 7));
  channel.interpolation = Interpolation::linear;
  EXPECT_EQ(rig::sample(channel, 1.5).head<3>(), Vector3d(3, 4, 5));
  EXPECT_EQ(rig::sample(channel, 3.0).head<3>(), Vector3d(7, 7, 7));
  EXPECT_EQ(rig::sample(channel, -1.0).head<3>(), Vector3d(1, 2, 3));
  EXPECT_EQ(rig::sample(channel, 4.0).head<3>(), Vector3d(9, 8, 7));
}

TEST(Sample, cubic_splines_pass_their_keys_with_their_tangents) {
  // In-tangent, value and out-tangent of each key.
  const Channel channel{0,
                        ChannelPath::scale,
                        Interpolation::cubic_spline,
                        {0.5, 2.5},
                        {9, 9, 9, 1, 2, 3, 0.5, -1, 2, -2, 0, 1, 4, 4, 4, 9, 9, 9}};
  EXPECT_EQ(rig::sample(channel, 0.5).head<3>(), Vector3d(1, 2, 3));
  EXPECT_EQ(rig::sample(channel, 2.5).head<3>(), Vector3d(4, 4, 4));
  const double e = 1e-6;
  const Vector3d leaving = (rig::sample(channel, 0.5 + e) - rig::sample(channel, 0.5)).head<3>() / e;
  const Vector3d arriving = (rig::sample(channel, 2.5) - rig::sample(channel, 2.5 - e)).head<3>() / e;
  // A one-sided difference is off by half the second derivative (below 10) times e.
  EXPECT_LT((leaving - Vector3d(0.5, -1, 2)).norm(), 2e-5);
  EXPECT_LT((arriving - Vector3d(-2, 0, 1)).norm(), 2e-5);
}

TEST(Sample, splines_of_rotations_stay_unit_even_through_zero) {
  const Channel channel{0,
                        ChannelPath::rotation,
                        Interpolation::cubic_spline,
                        {0.0, 1.0},
                        {0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -1, 0, 0, 0, 0}};
  for (int i = 0; i <= 8; ++i) EXPECT_NEAR(rig::sample(channel, i / 8.0).norm(), 1.0, rounding);
}

TEST(LocalTransform, is_translation_rotation_scale) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 1000; ++i) {
    const Vector4d q = random_rotation(random);
    const Vector3d t(1, -2, 3), s(2, -0.5, 4);
    Matrix4d expected = Matrix4d::Identity();
    expected.topLeftCorner<3, 3>() = quaternion(q).toRotationMatrix() * s.asDiagonal();
    expected.topRightCorner<3, 1>() = t;
    EXPECT_LT((rig::local_transform(t, 3.0 * q, s) - expected).cwiseAbs().maxCoeff(), rounding);
  }
}

// Two joints, the second a metre above the first.
rig::Character arm() {
  rig::Character character;
  character.root = rig::local_transform({0.5, 0, 0}, {0, 0, 0, 1}, {1, 1, 1});
  for (int j = 0; j < 2; ++j) {
    rig::Joint joint;
    joint.parent = j - 1;
    joint.rest_translation = Vector3d(0, j, 0);
    joint.rest_local = rig::local_transform(joint.rest_translation, joint.rest_rotation, joint.rest_scale);
    joint.inverse_bind(0, 3) = -0.5;
    joint.inverse_bind(1, 3) = -j;
    character.skeleton.push_back(joint);
  }
  const double r = std::sqrt(0.5);
  character.clips.push_back(
      {"bend",
       1.0,
       {{1, ChannelPath::rotation, Interpolation::linear, {0.0, 1.0}, {0, 0, 0, 1, 0, 0, r, r}}}});
  character.clips.push_back({"1", 0.0, {}});
  character.clips.push_back(
      {"lift", 2.0, {{0, ChannelPath::translation, Interpolation::linear, {0.0, 2.0}, {0, 0, 0, 0, 4, 0}}}});
  return character;
}

TEST(Pose, at_rest_is_the_identity) {
  const rig::Character character = arm();
  for (const Matrix4d& map : rig::pose_at(character, nullptr, 7.0)) EXPECT_EQ(map, Matrix4d::Identity());
}

TEST(Pose, a_bent_joint_takes_along_what_hangs_on_it) {
  const rig::Character character = arm();
  const std::vector<Matrix4d> pose = rig::pose_at(character, rig::find_clip(character, "bend"), 0.5);
  EXPECT_EQ(pose[0], Matrix4d::Identity());
  // 45 degrees about the joint at (0.5, 1, 0): the point one metre above it is now up and to the left.
  const Eigen::Vector4d tip = pose[1] * Eigen::Vector4d(0.5, 2, 0, 1);
  const double c = std::cos(std::numbers::pi / 4);
  EXPECT_LT((tip - Eigen::Vector4d(0.5 - c, 1 + c, 0, 1)).norm(), rounding);
}

TEST(Pose, a_moved_parent_carries_its_children) {
  const rig::Character character = arm();
  const rig::Clip* lift = rig::find_clip(character, "lift");
  for (const Matrix4d& map : rig::pose_at(character, lift, 0.5)) {
    EXPECT_EQ(map.topRightCorner(3, 1), Vector3d(0, 1, 0));
  }
  EXPECT_EQ(rig::joint_transforms_at(character, lift, 99.0)[1].topRightCorner(3, 1), Vector3d(0.5, 5, 0));
}

TEST(FindClip, by_name_then_by_number) {
  const rig::Character character = arm();
  EXPECT_EQ(rig::find_clip(character, ""), &character.clips[0]);
  EXPECT_EQ(rig::find_clip(character, "lift"), &character.clips[2]);
  EXPECT_EQ(rig::find_clip(character, "2"), &character.clips[2]);
  EXPECT_EQ(rig::find_clip(character, "1"), &character.clips[1]);  // a name takes precedence over an index
  EXPECT_EQ(rig::find_clip(rig::Character{}, ""), nullptr);
  EXPECT_THROW(rig::find_clip(rig::Character{}, "0"), base::SceneError);
  for (const char* name : {"3", "-1", "1x", "end", "99999999999999999999999"}) {
    try {
      rig::find_clip(character, name);
      ADD_FAILURE() << name << " was found";
    } catch (const base::SceneError& error) {
      EXPECT_NE(std::string(error.what()).find("`lift`"), std::string::npos) << error.what();
    }
  }
}

// Exporters prefix a clip's name with the armature's.
TEST(FindClip, by_the_last_part_of_its_name) {
  rig::Character character;
  for (const char* name : {"AnimalArmature|Gallop", "AnimalArmature|Gallop_Jump", "AnimalArmature|Idle_2",
                           "Dog:Walk", "Dog:walk", "FrogArmature|Frog_Attack"})
    character.clips.push_back({name, 1.0, {}});
  const auto found = [&](const char* name) { return rig::find_clip(character, name)->name; };
  EXPECT_EQ(found("Gallop"), "AnimalArmature|Gallop");
  EXPECT_EQ(found("gallop"), "AnimalArmature|Gallop");
  EXPECT_EQ(found("ANIMALARMATURE|GALLOP"), "AnimalArmature|Gallop");
  EXPECT_EQ(found("Walk"), "Dog:Walk");  // a case-sensitive match takes precedence
  EXPECT_EQ(found("walk"), "Dog:walk");
  EXPECT_EQ(found("Frog_Attack"), "FrogArmature|Frog_Attack");
  EXPECT_EQ(found("attack"), "FrogArmature|Frog_Attack");
  EXPECT_EQ(found("2"), "AnimalArmature|Idle_2");  // an index
  const auto refusal = [&](const char* name) -> std::string {
    try {
      return "found " + rig::find_clip(character, name)->name;
    } catch (const base::SceneError& error) {
      return error.what();
    }
  };
  EXPECT_EQ(refusal("WALK"),
            "`WALK` matches several clips: 3 `Dog:Walk`, 4 `Dog:walk`; give the number or the "
            "whole name");
  EXPECT_NE(refusal("Galop").find("did you mean Gallop?"), std::string::npos) << refusal("Galop");
  EXPECT_NE(refusal("llop").find("has no clip `llop`"), std::string::npos) << "part of a word does not match";
}

// Of a map that is not singular, the parts make the map again.
TEST(JointParts, make_the_map_again) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(0.25, 2.0);
  for (int i = 0; i < 200; ++i) {
    const Vector3d scale(i % 2 == 0 ? unit(random) : -unit(random), i % 3 == 0 ? -unit(random) : unit(random),
                         i % 5 == 0 ? -unit(random) : unit(random));
    const Matrix4d map =
        rig::local_transform({unit(random), unit(random), -3.0}, random_rotation(random), scale);
    const rig::JointParts parts = rig::joint_parts(map);
    const Matrix4d again = rig::local_transform(parts.translation, parts.rotation, parts.scale);
    EXPECT_LT((again - map).cwiseAbs().maxCoeff(), 100 * rounding) << i;
  }
}

TEST(JointParts, are_those_of_the_channels) {
  rig::Character character;
  character.skeleton.resize(2);
  character.skeleton[0].rest_scale = {1, 2, 3};
  character.skeleton[0].rest_local =
      rig::local_transform(Vector3d::Zero(), {0, 0, 0, 1}, character.skeleton[0].rest_scale);
  character.skeleton[1].parent = 0;
  const Vector4d turn = Vector4d(0.1, 0.2, 0.3, 0.9).normalized();
  rig::Clip clip;
  clip.channels.push_back({0, ChannelPath::scale, Interpolation::step, {0.0}, {0.0, -1.0, 0.0}});
  clip.channels.push_back(
      {1, ChannelPath::rotation, Interpolation::step, {0.0}, {turn[0], turn[1], turn[2], turn[3]}});
  const std::vector<rig::JointParts> rest = rig::joint_parts_at(character, nullptr, 0.0);
  EXPECT_EQ(rest[0].scale, Vector3d(1, 2, 3));
  const std::vector<rig::JointParts> parts = rig::joint_parts_at(character, &clip, 0.0);
  EXPECT_EQ(parts[0].scale, Vector3d(0, -1, 0)) << "a scale of zero and one below zero";
  EXPECT_EQ(parts[0].rotation, Vector4d(0, 0, 0, 1));
  EXPECT_LT((parts[1].rotation - turn).norm(), rounding) << "below a joint that has no volume";
}

}  // namespace
}  // namespace fascicle::tests
