// Which joints are bones, on a body made for it: a round column of skin from y = 0 to 2.
#include "host/build/bone_choice.h"

#include <cmath>
#include <map>
#include <numbers>

#include <gtest/gtest.h>

#include "host/gltf/gltf.h"
#include "tests/build/scenes.h"
#include "tests/build/surfaces.h"
#include "tests/support/assets.h"

namespace fascicle::tests::bone_choice_test {
namespace {

using build::BoneChoice;
using scene::Vector3d;

constexpr double radius = 0.2, height = 2.0;

enum Joint : std::uint32_t { floor_root, hip, chest, head, breast, twist, lid };

// The weights at a point of the column: hip, chest and head from bottom to top. The chest carries a breast, a
// twist joint shares the chest's flesh, and the centre of the head's top has its own joint.
std::vector<std::pair<Joint, double>> weights_at(const Vector3d& p) {
  if (p[1] < 1.0) return {{hip, 1.0}};
  if (p[1] > 1.999 && std::hypot(p[0], p[2]) < 0.06) return {{lid, 1.0}};
  if (p[1] >= 1.6) return {{head, 1.0}};
  if (p[1] > 1.1 && p[1] < 1.45 && p[2] > 0.14) return {{breast, 1.0}};
  return {{chest, 0.4}, {twist, 0.6}};
}

using WeightsAt = std::vector<std::pair<Joint, double>> (*)(const Vector3d&);

rig::Character column_of_flesh(WeightsAt weights_of = weights_at) {
  constexpr std::uint32_t around = 32, up = 80, across = 8;
  rig::Character c;
  c.skeleton = {joint_at("floor", -1, {1, -1, 0}),     joint_at("hip", 0, {0, 0.3, 0}),
                joint_at("chest", 1, {0, 1.0, 0}),     joint_at("head", 2, {0, 1.6, 0}),
                joint_at("breast", 2, {0, 1.25, 0.1}), joint_at("twist", 2, {0, 1.0, 0}),
                joint_at("lid", 3, {0, 1.95, 0})};
  // Rings from the centre of the bottom outwards, up, and to the centre of the top.
  std::vector<std::pair<double, double>> profile;  // radius, y
  for (std::uint32_t k = 1; k < across; ++k) profile.emplace_back(radius * k / across, 0.0);
  for (std::uint32_t k = 0; k <= up; ++k) profile.emplace_back(radius, height * k / up);
  for (std::uint32_t k = across; k-- > 1;) profile.emplace_back(radius * k / across, height);
  auto& vertices = c.surface.vertices;
  vertices.emplace_back(0, 0, 0);
  for (const auto& [r, y] : profile)
    for (std::uint32_t a = 0; a < around; ++a) {
      const double angle = 2.0 * std::numbers::pi * a / around;
      vertices.emplace_back(r * std::sin(angle), y, r * std::cos(angle));
    }
  vertices.emplace_back(0, height, 0);
  const auto ring = [&](std::size_t k, std::uint32_t a) {
    return static_cast<std::uint32_t>(1 + k * around + a % around);
  };
  const auto last = static_cast<std::uint32_t>(vertices.size() - 1);
  for (std::uint32_t a = 0; a < around; ++a) {
    c.surface.triangles.push_back({0, ring(0, a + 1), ring(0, a)});
    for (std::size_t k = 0; k + 1 < profile.size(); ++k) {
      c.surface.triangles.push_back({ring(k, a), ring(k, a + 1), ring(k + 1, a)});
      c.surface.triangles.push_back({ring(k, a + 1), ring(k + 1, a + 1), ring(k + 1, a)});
    }
    c.surface.triangles.push_back({ring(profile.size() - 1, a), ring(profile.size() - 1, a + 1), last});
  }
  for (const Vector3d& p : vertices) {
    std::array<std::uint32_t, 8> joints{};
    std::array<double, 8> weights{};
    std::size_t k = 0;
    for (const auto& [joint, w] : weights_of(p)) joints[k] = joint, weights[k++] = w;
    c.joints.push_back(joints);
    c.weights.push_back(weights);
  }
  return c;
}

BoneChoice choose(const scene::SkeletonSettings& settings = {}, double scale = 1.0) {
  return build::choose_bones(column_of_flesh(), settings, scale, "test");
}

TEST(BoneChoice, MeasuresTheSkin) {
  const BoneChoice choice = choose();
  const double whole = 2 * std::numbers::pi * radius * (height + radius);
  // The head's tube and cap. The tolerance covers the 32-sided polygon and one row of triangles at the lower
  // end.
  const double head_area = 2 * std::numbers::pi * radius * 0.4 + std::numbers::pi * radius * radius;
  EXPECT_NEAR(choice.report[head].share, head_area / whole, 0.03 * head_area / whole + 0.01);
  // The hole where the head is cut off, relative to its skin.
  EXPECT_NEAR(choice.report[head].openness, std::numbers::pi * radius * radius / head_area, 0.02);
  EXPECT_NEAR(choice.report[hip].share, 1.0, 1e-12);
  // A closed surface has no hole; the tolerance covers the rounding of a few thousand area vectors.
  EXPECT_NEAR(choice.report[hip].openness, 0.0, 1e-12);
  EXPECT_GT(choice.report[breast].share, 0.01);
  EXPECT_GT(choice.report[breast].openness, 0.8);
  EXPECT_LT(choice.report[lid].share, 0.01);
}

// The same column in clothes: a single-layer tube, open at both ends, around hip and chest.
rig::Character column_in_a_tube(double facing) {
  rig::Character c = column_of_flesh();
  constexpr std::uint32_t around = 32, up = 20;
  constexpr double wide = 1.1 * radius, low = 0.1, high = 1.55;
  const auto first = static_cast<std::uint32_t>(c.surface.vertices.size());
  for (std::uint32_t k = 0; k <= up; ++k)
    for (std::uint32_t a = 0; a < around; ++a) {
      const double angle = 2.0 * std::numbers::pi * a / around, y = low + (high - low) * k / up;
      c.surface.vertices.emplace_back(facing * wide * std::sin(angle), y, wide * std::cos(angle));
      c.joints.push_back({y < 1.0 ? hip : chest});
      c.weights.push_back({1.0});
    }
  const auto at = [&](std::uint32_t k, std::uint32_t a) { return first + k * around + a % around; };
  for (std::uint32_t k = 0; k < up; ++k)
    for (std::uint32_t a = 0; a < around; ++a) {
      c.surface.triangles.push_back({at(k, a), at(k, a + 1), at(k + 1, a)});
      c.surface.triangles.push_back({at(k, a + 1), at(k + 1, a + 1), at(k + 1, a)});
    }
  return c;
}

// A ray from the bone crosses body and tube, so two triangles, as if it came from outside.
TEST(BoneChoice, BonesAreInsideOfClothesToo) {
  for (const double facing : {1.0, -1.0}) {
    const BoneChoice choice = build::choose_bones(column_in_a_tube(facing), {}, 1.0, "test");
    for (const Joint joint : {hip, chest, head})
      EXPECT_TRUE(choice.report[joint].is_bone)
          << choice.report[joint].name << ": " << choice.report[joint].reason;
    EXPECT_FALSE(choice.report[floor_root].is_bone);
  }
}

TEST(BoneChoice, JointsThatClipsTurnBearNoFreeFlesh) {
  rig::Character c = column_of_flesh();
  const auto choice_with = [&](double degrees) {
    const double half = degrees / 2.0 * std::numbers::pi / 180.0;
    rig::Channel turn{
        .joint = breast, .path = rig::ChannelPath::rotation, .times = {0.0, 0.5, 1.0}, .values = {}};
    // Starts in the middle, then turns to one side and to the other.
    for (const double angle : {0.0, half / 2.0, -half / 2.0})
      for (const double value : {std::sin(angle), 0.0, 0.0, std::cos(angle)}) turn.values.push_back(value);
    c.clips = {{.name = "flop", .duration = 1.0, .channels = {turn}}};
    return build::choose_bones(c, {}, 1.0, "test");
  };
  EXPECT_FALSE(choice_with(15.0).report[breast].is_kinematic);
  EXPECT_TRUE(choice_with(25.0).report[breast].is_kinematic);
}

// Short limbs in front of and behind the hip: a patch of the column is the thigh, and a capped tube on it is
// the foot. For a tube of length l and radius r, the hole is r / (r + 2 l) of its skin.
rig::Character column_with_limbs(double before, double behind) {
  rig::Character c = column_of_flesh();
  constexpr double wide = 0.1;
  constexpr std::uint32_t around = 32;
  for (const auto& [length, side] : {std::pair{before, 1.0}, {behind, -1.0}}) {
    const auto thigh = static_cast<std::uint32_t>(c.skeleton.size()), foot = thigh + 1;
    const std::string end = side > 0.0 ? ".F" : ".B";
    c.skeleton.push_back(joint_at(("thigh" + end).c_str(), hip, {0, 0.5, 0.1 * side}));
    c.skeleton.push_back(joint_at(("foot" + end).c_str(), static_cast<int>(thigh), {0, 0.5, 0.2 * side}));
    for (std::size_t v = 0; v < c.surface.vertices.size(); ++v) {
      const Vector3d& p = c.surface.vertices[v];
      if (std::abs(p[1] - 0.5) > 0.15 || side * p[2] < 0.1 || side * p[2] > radius + 1e-6) continue;
      c.joints[v] = {thigh};
      c.weights[v] = {1.0};
    }
    const auto first = static_cast<std::uint32_t>(c.surface.vertices.size());
    for (const double along : {0.0, length})
      for (std::uint32_t a = 0; a < around; ++a) {
        const double angle = side * 2.0 * std::numbers::pi * a / around;
        c.surface.vertices.emplace_back(wide * std::cos(angle), 0.5 + wide * std::sin(angle),
                                        side * (0.2 + along));
      }
    c.surface.vertices.emplace_back(0, 0.5, side * (0.2 + length));
    const std::uint32_t middle = first + 2 * around;
    for (std::uint32_t a = 0; a < around; ++a) {
      const std::uint32_t b = (a + 1) % around, low = first, high = first + around;
      c.surface.triangles.push_back({low + a, low + b, high + a});
      c.surface.triangles.push_back({low + b, high + b, high + a});
      c.surface.triangles.push_back({high + a, high + b, middle});
    }
    c.joints.resize(c.surface.vertices.size(), {foot});
    c.weights.resize(c.surface.vertices.size(), {1.0});
  }
  return c;
}

TEST(BoneChoice, ShortLimbsEndInTheirLowerJoint) {
  const BoneChoice choice = build::choose_bones(column_with_limbs(0.06, 0.06), {}, 1.0, "test");
  for (std::size_t thigh : {lid + 1u, lid + 3u}) {
    const build::JointReport &upper = choice.report[thigh], &lower = choice.report[thigh + 1];
    ASSERT_GT(upper.openness, build::least_open_flesh) << upper.reason;
    ASSERT_GT(lower.openness, build::most_open_limb) << lower.reason;
    EXPECT_TRUE(upper.is_bone) << upper.reason;
    EXPECT_FALSE(upper.is_kinematic);
    EXPECT_TRUE(lower.is_bone) << lower.reason;
    EXPECT_TRUE(lower.ends_chain);
  }
}

TEST(BoneChoice, WhatIsAlikeOnBothSidesIsTreatedAlike) {
  // The holes are 0.345 and 0.323 of the feet's skin, just above and just below a third.
  const BoneChoice choice = build::choose_bones(column_with_limbs(0.095, 0.105), {}, 1.0, "test");
  const build::JointReport &before = choice.report[lid + 2], &behind = choice.report[lid + 4];
  ASSERT_GT(before.openness, build::most_open_limb);
  ASSERT_LT(behind.openness, build::most_open_limb);
  EXPECT_NE(behind.reason.find("closes around it"), std::string::npos) << behind.reason;
  EXPECT_NE(before.reason.find("is like foot.B"), std::string::npos) << before.reason;
}

TEST(BoneChoice, TakesWhatSkinSurroundsAndNothingElse) {
  const BoneChoice choice = choose();
  const std::vector<char> expected{0, 1, 1, 1, 0, 0, 0};
  for (std::size_t j = 0; j < expected.size(); ++j)
    EXPECT_EQ(choice.report[j].is_bone, expected[j] != 0) << choice.report[j].name;
  EXPECT_TRUE(choice.report[head].ends_chain);
  EXPECT_FALSE(choice.report[chest].ends_chain);

  ASSERT_EQ(choice.bones.size(), 3u);
  EXPECT_EQ(choice.bones[0].from, Vector3d(0, 0.3, 0));
  EXPECT_EQ(choice.bones[0].to, Vector3d(0, 1, 0));
  EXPECT_EQ(choice.bones[0].owners, (std::array<std::int32_t, 3>{hip, -1, chest}));
  EXPECT_EQ(choice.bones[1].owners, (std::array<std::int32_t, 3>{chest, hip, head}));
  // The head's bone extends up into its skin and ends inside.
  EXPECT_EQ(choice.bones[2].owners, (std::array<std::int32_t, 3>{head, chest, -1}));
  EXPECT_NEAR(choice.bones[2].to[0], 0.0, 1e-12);
  EXPECT_GT(choice.bones[2].to[1], 1.8);
  EXPECT_LT(choice.bones[2].to[1], 2.0);

  // Weights of joints that are not bones count for the bone above.
  EXPECT_EQ(choice.joints[breast].bone, chest);
  EXPECT_EQ(choice.joints[twist].bone, chest);
  EXPECT_EQ(choice.joints[lid].bone, head);
  EXPECT_EQ(choice.joints[floor_root].bone, -1);
}

TEST(BoneChoice, EndsAreKinematicAndFleshOnTheTrunkIsNot) {
  const BoneChoice choice = choose();
  const std::vector<char> expected{0, 0, 0, 1, 0, 0, 1};
  for (std::size_t j = 0; j < expected.size(); ++j)
    EXPECT_EQ(choice.joints[j].is_kinematic, expected[j] != 0) << choice.report[j].name;
}

using Names = std::vector<std::string>;
BoneChoice choose_with(Names scene::SkeletonSettings::*key, const Names& names) {
  scene::SkeletonSettings settings;
  settings.*key = names;
  return choose(settings);
}

TEST(BoneChoice, CanBeOverridden) {
  using Settings = scene::SkeletonSettings;
  BoneChoice choice = choose_with(&Settings::bones, {"breast"});
  EXPECT_TRUE(choice.report[breast].is_bone);
  EXPECT_TRUE(choice.report[breast].is_kinematic);  // ends a chain
  choice = choose_with(&Settings::not_bones, {"head"});
  EXPECT_FALSE(choice.report[head].is_bone);
  EXPECT_TRUE(choice.report[chest].ends_chain);
  choice = choose_with(&Settings::kinematic, {"breast"});
  EXPECT_TRUE(choice.report[breast].is_kinematic);
  choice = choose_with(&Settings::simulated, {"head"});
  EXPECT_TRUE(choice.report[head].is_bone);
  EXPECT_FALSE(choice.report[head].is_kinematic);
  EXPECT_FALSE(choice.report[lid].is_kinematic);  // below the head
  Settings coarse;
  coarse.least_share = 0.3;
  EXPECT_FALSE(choose(coarse).report[head].is_bone);
  expect_refusal([] { choose_with(&Settings::bones, {"nose"}); },
                 "skeleton.bones: no joint is called \"nose\"");
  expect_refusal([] { choose_with(&Settings::simulated, {"nose"}); }, "skeleton.simulated");
}

TEST(BoneChoice, DoesNotDependOnTheUnit) {
  const BoneChoice metres = choose(), millimetres = choose({}, 0.001);
  ASSERT_EQ(metres.bones.size(), millimetres.bones.size());
  for (std::size_t b = 0; b < metres.bones.size(); ++b)
    EXPECT_LE((metres.bones[b].to * 0.001 - millimetres.bones[b].to).norm(), 1e-15);
  for (std::size_t j = 0; j < metres.joints.size(); ++j)
    EXPECT_EQ(metres.joints[j].is_kinematic, millimetres.joints[j].is_kinematic);
}

TEST(BoneChoice, LeadsThroughNodesThatDoNotSkin) {
  rig::Character c = column_of_flesh();
  c.skeleton[chest].skins = false;
  for (auto& joints : c.joints)
    for (std::uint32_t& joint : joints)
      if (joint == chest) joint = hip;
  const BoneChoice choice = build::choose_bones(c, {}, 1.0, "test");
  EXPECT_FALSE(choice.report[chest].is_bone);
  EXPECT_EQ(choice.bones[0].owners, (std::array<std::int32_t, 3>{hip, -1, head}));
}

TEST(BoneChoice, RefusesAMatrixWithoutInverse) {
  rig::Character c = column_of_flesh();
  c.skeleton[hip].inverse_bind.setZero();
  expect_refusal([&] { build::choose_bones(c, {}, 1.0, "test"); }, "\"hip\"");
}

// Eighty joints beside each other, each of them too small for a bone.
TEST(BoneChoice, WarnsOfJointsThatAreAllTooSmall) {
  constexpr int count = 80;
  rig::Character c = column_of_flesh([](const Vector3d& p) -> std::vector<std::pair<Joint, double>> {
    return {{static_cast<Joint>(1 + std::min(static_cast<int>(p[1] / height * count), count - 1)), 1.0}};
  });
  c.skeleton = {joint_at("root", -1, {0, 0.1, 0})};
  for (int k = 0; k < count; ++k)
    c.skeleton.push_back(joint_at(("b" + std::to_string(k)).c_str(), 0, {0, (k + 0.5) * height / count, 0}));
  scene::SkeletonSettings settings;
  settings.least_share = 0.02;
  const BoneChoice choice = build::choose_bones(c, settings, 1.0, "test");
  EXPECT_NE(choice.warning.find("each moves less than 2"), std::string::npos) << choice.warning;
  EXPECT_NE(choice.warning.find("skeleton.simulated = [\"root\"]"), std::string::npos) << choice.warning;
  // Its advice works.
  settings.simulated = {"root"};
  const BoneChoice simulated = build::choose_bones(c, settings, 1.0, "test");
  EXPECT_EQ(simulated.warning, "");
  for (const build::JointUse& joint : simulated.joints) EXPECT_FALSE(joint.is_kinematic) << joint.name;
  EXPECT_EQ(choose().warning, "");
}

// A translation of 1e8 makes a rotation look singular. Beyond 1e9 m nothing is simulated.
TEST(BoneChoice, WorksFarFromTheOrigin) {
  const auto choose_at = [](double far) {
    rig::Character c = column_of_flesh();
    for (Vector3d& p : c.surface.vertices) p[0] += far;
    for (rig::Joint& joint : c.skeleton) joint.inverse_bind(0, 3) -= far;
    return build::choose_bones(c, {}, 1.0, "test");
  };
  const BoneChoice near = choose();
  for (const double far : {1e7, 1e8, 9e8}) {
    const BoneChoice choice = choose_at(far);
    ASSERT_EQ(choice.bones.size(), near.bones.size()) << far;
    // Numbers of 9e8 have steps of 1.2e-7, and some of them make a place.
    for (std::size_t b = 0; b < near.bones.size(); ++b)
      EXPECT_LE((choice.bones[b].from - Vector3d(far, 0, 0) - near.bones[b].from).norm(), 1e-6) << far;
  }
  for (const double far : {1e9, 1e12})
    expect_refusal([&] { choose_at(far); }, "m away from the origin, which cannot be simulated");
}

// A leg whose foot is parented to the floor joint instead of the shank and is far away, as for an IK target.
TEST(BoneChoice, LegsLeadToFeetThatAreTargetsOfTheirOwn) {
  enum Leg : std::uint32_t { ground, thigh, shank, foot };
  rig::Character c = column_of_flesh([](const Vector3d& p) -> std::vector<std::pair<Joint, double>> {
    return {{static_cast<Joint>(p[1] > 1.2 ? thigh : p[1] > 0.3 ? shank : foot), 1.0}};
  });
  c.skeleton = {joint_at("ground", -1, {1, -1, 0}), joint_at("thigh", ground, {0, 1.9, 0}),
                joint_at("shank", thigh, {0, 1.2, 0}), joint_at("foot", ground, {0.5, -0.1, 0})};
  for (const bool is_below : {false, true}) {
    // The control: with the foot parented to the shank, the bones are the same except at the foot's position.
    if (is_below) c.skeleton[foot] = joint_at("foot", shank, {0, 0.3, 0});
    const BoneChoice choice = build::choose_bones(c, {}, 1.0, "test");
    EXPECT_FALSE(choice.report[ground].is_bone);
    EXPECT_TRUE(choice.report[foot].is_bone) << choice.report[foot].reason;
    EXPECT_TRUE(choice.report[foot].ends_chain);
    EXPECT_FALSE(choice.report[shank].ends_chain);
    EXPECT_FALSE(choice.joints[shank].is_kinematic);
    ASSERT_EQ(choice.bones.size(), 3u);
    EXPECT_EQ(choice.bones[1].owners, (std::array<std::int32_t, 3>{shank, thigh, foot}));
    // The row of triangles between the two spans 0.3 to 0.325.
    EXPECT_NEAR(choice.bones[1].to[1], 0.3, 0.03);
    EXPECT_NEAR(choice.bones[1].to[0], 0.0, 1e-9);
    EXPECT_NEAR(choice.bones[2].from[1], 0.3, 0.03);
    EXPECT_LT(choice.bones[2].to[1], 0.15);
    EXPECT_GT(choice.bones[2].to[1], 0.0);
  }
}

// A head as flat as a breast is a bone because a chain continues into it; the breast is not.
TEST(BoneChoice, ChainsGoOnIntoFlatSkin) {
  enum Torso : std::uint32_t { ground, pelvis, spine, neck, bosom, top };
  rig::Character c = column_of_flesh([](const Vector3d& p) -> std::vector<std::pair<Joint, double>> {
    if (p[1] > 1.1 && p[1] < 1.45 && p[2] > 0.14) return {{static_cast<Joint>(bosom), 1.0}};
    return {{static_cast<Joint>(p[1] < 1.0 ? pelvis : p[1] < 1.75 ? spine : p[1] < 1.9 ? neck : top), 1.0}};
  });
  c.skeleton = {joint_at("ground", -1, {1, -1, 0}),       joint_at("pelvis", ground, {0, 0.3, 0}),
                joint_at("spine", pelvis, {0, 1.0, 0}),   joint_at("neck", spine, {0, 1.75, 0}),
                joint_at("bosom", spine, {0, 1.25, 0.1}), joint_at("top", neck, {0, 1.9, 0})};
  const BoneChoice choice = build::choose_bones(c, {}, 1.0, "test");
  EXPECT_GT(choice.report[top].openness, build::most_open_limb);
  EXPECT_TRUE(choice.report[top].is_bone) << choice.report[top].reason;
  EXPECT_TRUE(choice.joints[top].is_kinematic);
  EXPECT_FALSE(choice.report[bosom].is_bone) << choice.report[bosom].reason;
  EXPECT_FALSE(choice.joints[bosom].is_kinematic);
}

TEST(BoneChoice, SaysWhy) {
  const BoneChoice choice = choose();
  for (const build::JointReport& joint : choice.report) {
    EXPECT_TRUE(joint.reason.starts_with(joint.is_bone ? "bone: " : "no bone: ")) << joint.reason;
    if (joint.share > 0.0) {
      EXPECT_EQ(joint.reason.find("follows the skeleton") != std::string::npos, joint.is_kinematic)
          << joint.reason;
    }
  }
  EXPECT_NE(choice.report[twist].reason.find("around the bone of chest"), std::string::npos);
}

// What a person would choose on characters not made for this test: the number of bones and all ends of
// chains. `free` and `kinematic` are joints that are not bones, with free and with kinematic flesh.
struct Expected {
  std::string file;
  std::size_t bones;
  std::vector<std::string> ends, kinematic, free;
};

void expect_choice(const Expected& expected) {
  FASCICLE_NEEDS_ASSET(asset(expected.file));
  const rig::Character character = gltf::read_gltf(asset(expected.file));
  const BoneChoice choice = build::choose_bones(character, {}, 1.0, expected.file);
  EXPECT_EQ(choice.warning, "");
  std::map<std::string, build::JointReport> named;
  std::size_t bones = 0;
  std::vector<std::string> ends;
  for (const build::JointReport& joint : choice.report) {
    named[joint.name] = joint;
    bones += joint.is_bone ? 1 : 0;
    if (joint.ends_chain) ends.push_back(joint.name);
  }
  EXPECT_EQ(bones, expected.bones);
  std::vector<std::string> sorted = expected.ends;
  std::sort(sorted.begin(), sorted.end());
  std::sort(ends.begin(), ends.end());
  EXPECT_EQ(ends, sorted);
  for (const std::string& name : expected.kinematic) {
    EXPECT_FALSE(named.at(name).is_bone) << name;
    EXPECT_TRUE(named.at(name).is_kinematic) << name;
  }
  for (const std::string& name : expected.free) {
    EXPECT_FALSE(named.at(name).is_bone) << name;
    EXPECT_FALSE(named.at(name).is_kinematic) << name;
  }
}

TEST(BoneChoice, OfAHeavyMan) {
  expect_choice({"mh_fat.glb",
                 36,
                 {"head", "wrist.L", "wrist.R", "foot.L", "foot.R"},
                 {"jaw", "metacarpal1.L", "finger1-1.R", "toe1-1.L"},
                 {"breast.L", "breast.R"}});
}

TEST(BoneChoice, OfAMuscularMan) {
  expect_choice({"mh_muscle.glb",
                 36,
                 {"head", "wrist.L", "wrist.R", "foot.L", "foot.R"},
                 {"jaw", "metacarpal1.L", "finger1-1.R", "toe1-1.L"},
                 {"breast.L", "breast.R"}});
}

TEST(BoneChoice, OfAFox) {
  expect_choice({"animals_pack_Fox.glb",
                 33,
                 {"Head", "Tail7", "IKBackLeg.L", "IKBackLeg.R", "IKFrontLeg.L", "IKFrontLeg.R"},
                 {"Ear1.L", "Ear1.R", "Tail8", "FF.L", "FFB.R"},
                 {"Body"}});
}

TEST(BoneChoice, OfABull) {
  expect_choice({"animals_pack_Bull.glb",
                 30,
                 {"Head", "Tail4", "IKBackLeg.L", "IKBackLeg.R", "IKFrontLeg.L", "IKFrontLeg.R"},
                 {"Tail5", "Tail7", "FF.L", "FFB.R"},
                 {"Body"}});
}

// The rump has its own joint and is soft. The belly's joint ends a chain in the hierarchy but not in space.
TEST(BoneChoice, OfAFrog) {
  expect_choice({"easy_enemies_Frog.glb",
                 23,
                 {"Head", "FrontFoot.L", "FrontFoot.R", "BackFoot.L", "BackFoot.R"},
                 {},
                 {"root", "Body", "Back"}});
}

TEST(BoneChoice, OfATyrannosaur) {
  expect_choice({"dinosaurs_pack_Trex.glb",
                 26,
                 {"Head", "Tail5", "FrontLowLeg.L", "FrontLowLeg.R", "BackFoot.L", "BackFoot.R"},
                 {"FrontFoot.L", "FrontFoot.R"},
                 {"root"}});
}

TEST(BoneChoice, OfAClothedWoman) {
  expect_choice({"modular_women_Formal.glb",
                 20,
                 {"Head", "Hand.L", "Hand.R", "Foot.L", "Foot.R"},
                 {"Index1.L", "Thumb1.R"},
                 {"Root"}});
}

TEST(BoneChoice, OfAWalkingMan) {
  expect_choice({"CesiumMan.glb",
                 19,
                 {"Skeleton_neck_joint_2", "Skeleton_arm_joint_L__2_", "Skeleton_arm_joint_R__3_",
                  "leg_joint_L_5", "leg_joint_R_5"},
                 {},
                 {}});
}

}  // namespace
}  // namespace fascicle::tests::bone_choice_test
