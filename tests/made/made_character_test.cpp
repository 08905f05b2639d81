// Generated characters: their skins, weights, and clips that respect the ground, gravity and joint limits.
#include "host/made/made_character.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "host/base/errors.h"
#include "host/made/made_bear.h"
#include "host/made/made_mesh.h"
#include "host/made/made_motion.h"
#include "host/rig/pose.h"

namespace fascicle::tests {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector3d;

constexpr double degrees = 57.29577951308232;

class MadeCharacters : public testing::TestWithParam<std::string> {
 protected:
  const rig::Character character_ = made::make_character(GetParam());
};

TEST_P(MadeCharacters, HaveAClosedSkinThatFacesOutwards) {
  const mesh::SurfaceMesh& skin = character_.surface;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
  std::set<std::uint32_t> used;
  double volume = 0.0;
  for (const auto& t : skin.triangles) {
    for (std::size_t c = 0; c < 3; ++c) ++sides[{t[c], t[(c + 1) % 3]}];
    used.insert(t.begin(), t.end());
    volume += skin.vertices[t[0]].dot(skin.vertices[t[1]].cross(skin.vertices[t[2]])) / 6.0;
  }
  for (const auto& [side, count] : sides) {
    EXPECT_EQ(count, 1);
    EXPECT_TRUE(sides.count({side.second, side.first}));
  }
  EXPECT_EQ(used.size(), skin.vertices.size());
  // Topologically a sphere, without handles or fused limbs, and the triangles around each vertex form one
  // fan.
  EXPECT_EQ(skin.vertices.size() + skin.triangles.size() - sides.size() / 2, 2u);
  std::vector<std::map<std::uint32_t, std::uint32_t>> fan(skin.vertices.size());
  for (const auto& t : skin.triangles)
    for (std::size_t c = 0; c < 3; ++c) fan[t[c]][t[(c + 1) % 3]] = t[(c + 2) % 3];
  for (const auto& around : fan) {
    std::size_t steps = 0;
    const std::uint32_t first = around.begin()->first;
    std::uint32_t at = first;
    do {
      at = around.at(at);
      ++steps;
    } while (at != first && steps <= around.size());
    EXPECT_EQ(steps, around.size());
  }
  EXPECT_GT(volume, 0.0);
}

TEST_P(MadeCharacters, HaveEvenTriangles) {
  const mesh::SurfaceMesh& skin = character_.surface;
  std::vector<double> edges;
  double least_quality = 1.0;
  for (const auto& t : skin.triangles) {
    const Vector3d &a = skin.vertices[t[0]], &b = skin.vertices[t[1]], &c = skin.vertices[t[2]];
    edges.insert(edges.end(), {(b - a).norm(), (c - b).norm(), (a - c).norm()});
    const double squares = (b - a).squaredNorm() + (c - b).squaredNorm() + (a - c).squaredNorm();
    least_quality = std::min(least_quality, 2.0 * std::sqrt(3.0) * (b - a).cross(c - a).norm() / squares);
  }
  std::sort(edges.begin(), edges.end());
  // The guarantees of polygonise.
  EXPECT_LT(edges[edges.size() * 99 / 100], 2.5 * edges[edges.size() / 100]);
  // 1 is equilateral; a needle of 10 to 1 has 0.17.
  EXPECT_GT(least_quality, 0.15);
}

TEST_P(MadeCharacters, HaveWeightsThatSumToOne) {
  ASSERT_EQ(character_.weights.size(), character_.surface.vertices.size());
  std::set<std::uint32_t> used;
  for (std::size_t i = 0; i < character_.weights.size(); ++i) {
    double sum = 0.0;
    for (std::size_t k = 0; k < 8; ++k) {
      const double w = character_.weights[i][k];
      EXPECT_GE(w, 0.0);
      sum += w;
      if (w > 0.5) used.insert(character_.joints[i][k]);
    }
    EXPECT_NEAR(sum, 1.0, 1e-12);  // a dozen roundings
    EXPECT_EQ(character_.weights[i][6] + character_.weights[i][7], 0.0);
  }
  EXPECT_EQ(used.size(), character_.skeleton.size()) << "a joint without flesh";
}

// Neighbours on the skin have similar weights: a jump would be a crease.
TEST_P(MadeCharacters, HaveWeightsThatChangeSmoothly) {
  std::vector<std::map<std::uint32_t, double>> weight(character_.weights.size());
  for (std::size_t i = 0; i < weight.size(); ++i)
    for (std::size_t k = 0; k < 8; ++k) weight[i][character_.joints[i][k]] += character_.weights[i][k];
  double largest = 0.0;
  for (const auto& t : character_.surface.triangles)
    for (std::size_t c = 0; c < 3; ++c) {
      const auto &a = weight[t[c]], &b = weight[t[(c + 1) % 3]];
      double step = 0.0;
      for (const auto& [joint, w] : a) step += std::max(0.0, w - (b.count(joint) ? b.at(joint) : 0.0));
      largest = std::max(largest, step);
    }
  // Elbows and wrists blend from one joint to the next within three edges.
  EXPECT_LT(largest, 0.5);
}

TEST_P(MadeCharacters, AreTheSameEachTime) {
  const rig::Character again = made::make_character(GetParam());
  EXPECT_EQ(again.surface.vertices, character_.surface.vertices);
  EXPECT_EQ(again.surface.triangles, character_.surface.triangles);
  EXPECT_EQ(again.weights, character_.weights);
  ASSERT_EQ(again.clips.size(), character_.clips.size());
  for (std::size_t c = 0; c < again.clips.size(); ++c)
    for (std::size_t k = 0; k < again.clips[c].channels.size(); ++k)
      EXPECT_EQ(again.clips[c].channels[k].values, character_.clips[c].channels[k].values);
}

TEST_P(MadeCharacters, BindPoseIsTheRestPose) {
  for (const Matrix4d& map : rig::pose_at(character_, nullptr, 0.0))
    // A sum and a difference of coordinates below 2 m.
    EXPECT_LT((map - Matrix4d::Identity()).cwiseAbs().maxCoeff(), 1e-15 * 4);
}

INSTANTIATE_TEST_SUITE_P(All, MadeCharacters, testing::ValuesIn(made::made_character_names()),
                         [](const auto& character) {
                           std::string name = character.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST(MadeCharacter, UnknownNamesAreRefused) {
  EXPECT_THROW(made::make_character("wolf"), base::SceneError);
}

class BearJump : public testing::Test {
 protected:
  std::size_t joint(const std::string& name) const {
    for (std::size_t j = 0; j < bear_.skeleton.size(); ++j)
      if (bear_.skeleton[j].name == name) return j;
    throw std::out_of_range(name);
  }
  std::vector<Vector3d> places(double time) const {
    std::vector<Vector3d> places;
    for (const Matrix4d& m : rig::joint_transforms_at(bear_, &bear_.clips.at(0), time))
      places.push_back(m.topRightCorner<3, 1>());
    return places;
  }
  std::vector<Vector3d> skin(double time) const {
    const std::vector<Matrix4d> pose = rig::pose_at(bear_, &bear_.clips.at(0), time);
    std::vector<Vector3d> skin;
    for (std::size_t i = 0; i < bear_.surface.vertices.size(); ++i) {
      Vector3d p = Vector3d::Zero();
      for (std::size_t k = 0; k < 8; ++k)
        p += bear_.weights[i][k] *
             (pose[bear_.joints[i][k]] * bear_.surface.vertices[i].homogeneous()).head<3>();
      skin.push_back(p);
    }
    return skin;
  }
  static constexpr double end_of_flight = made::jump_take_off + made::jump_flight;
  const rig::Character bear_ = made::make_character("bear");
};

TEST_F(BearJump, MovesTheWayAJumpDoes) {
  EXPECT_EQ(bear_.clips.at(0).name, "jump");
  EXPECT_NEAR(bear_.clips[0].duration, 3.2, 0.5);
  const auto hips = [&](double time) { return places(time)[joint("hips")].y(); };
  const auto wrist = [&](double time) {
    const auto at = places(time);
    return Vector3d(at[joint("hand_L")] - at[joint("upper_arm_L")]);
  };
  double lowest = hips(0), crouch = 0.0;
  for (double t = 0.0; t < made::jump_take_off; t += 0.01)
    if (hips(t) < lowest) lowest = hips(t), crouch = t;
  EXPECT_LT(lowest, hips(0) - 0.1) << "anticipation";
  EXPECT_LT(wrist(crouch - 0.1).z(), -0.1) << "arms back";
  EXPECT_GT(wrist(made::jump_take_off).y(), 0.1) << "arms up";
  EXPECT_GT(hips(made::jump_take_off + made::jump_flight / 2), hips(0) + 0.3);
  double landed = 1e30;
  for (double t = end_of_flight; t < end_of_flight + 0.6; t += 0.01) landed = std::min(landed, hips(t));
  EXPECT_LT(landed, lowest) << "the landing is deeper than the anticipation";
  EXPECT_NEAR(hips(bear_.clips[0].duration), hips(0), 1e-3) << "and it recovers";
}

TEST_F(BearJump, FeetDoNotSlide) {
  const auto still = [&](const std::string& name, double from, double to, double bound) {
    const Vector3d first = places(from)[joint(name)];
    double most = 0.0;
    for (double t = from; t <= to; t += 1.0 / 960.0)
      most = std::max(most, (places(t)[joint(name)] - first).norm());
    EXPECT_LT(most, bound) << name << " between " << from << " and " << to << " s";
  };
  for (const std::string side : {"_L", "_R"}) {
    // Between two keys a leg's joints rotate at a constant rate and the hips move along a line: the foot is
    // at most half a millimetre off its place at the keys.
    still("toe" + side, 0.0, made::jump_take_off, 5e-4);
    still("toe" + side, end_of_flight, bear_.clips[0].duration, 5e-4);
    still("foot" + side, 0.0, 0.85, 5e-4);
    still("foot" + side, end_of_flight + 0.08, bear_.clips[0].duration, 5e-4);
  }
  // Nothing goes through the floor; only skinning rounds the soles.
  for (double t = 0.0; t < bear_.clips[0].duration; t += 0.05)
    for (const Vector3d& p : skin(t)) EXPECT_GT(p.y(), -0.012) << t;
}

// The centre of the skin's volume falls along a parabola. The clip treats each joint's flesh as rigid, but
// skinning bends it: 8 mm in a flight of 40 cm.
TEST_F(BearJump, FliesAlongAParabola) {
  const auto middle = [&](double time) {
    const std::vector<Vector3d> p = skin(time);
    Vector3d sum = Vector3d::Zero();
    double volume = 0.0;
    for (const auto& t : bear_.surface.triangles) {
      const double v = p[t[0]].dot(p[t[1]].cross(p[t[2]]));
      sum += v * (p[t[0]] + p[t[1]] + p[t[2]]) / 4.0;
      volume += v;
    }
    return Vector3d(sum / volume);
  };
  const Vector3d from = middle(made::jump_take_off), to = middle(end_of_flight);
  for (int k = 1; k < 14; ++k) {
    const double u = k / 14.0, t = u * made::jump_flight;
    Vector3d expected = from + u * (to - from);
    expected.y() += 0.5 * made::jump_gravity * t * (made::jump_flight - t);
    EXPECT_LT((middle(made::jump_take_off + t) - expected).norm(), 8e-3) << t;
  }
}

TEST_F(BearJump, BendsItsJointsAsFarAsJointsGo) {
  const auto angle = [](const Vector3d& a, const Vector3d& b) {
    return degrees * std::acos(std::clamp(a.normalized().dot(b.normalized()), -1.0, 1.0));
  };
  double deepest_knee = 0.0;
  std::vector<double> before;
  for (int k = 0; k <= 384; ++k) {
    const double time = k / 120.0;
    const std::vector<Vector3d> at = places(time);
    const Matrix4d hips = rig::joint_transforms_at(bear_, &bear_.clips[0], time)[joint("hips")];
    std::vector<double> now;
    for (const std::string side : {"_L", "_R"}) {
      const auto bone = [&](const std::string& a, const std::string& b) {
        return Vector3d(at[joint(b + side)] - at[joint(a + side)]);
      };
      const Vector3d thigh = bone("thigh", "shin"), shin = bone("shin", "foot"), foot = bone("foot", "toe"),
                     upper = bone("upper_arm", "forearm"), lower = bone("forearm", "hand");
      const double knee = angle(thigh, shin), hip = angle(thigh, -hips.block<3, 1>(0, 1)),
                   ankle = angle(shin, foot), elbow = angle(upper, lower);
      deepest_knee = std::max(deepest_knee, knee);
      EXPECT_LT(knee, 140.0) << time;
      EXPECT_GT(knee, 3.0) << time << ": a straight leg cannot reach";
      EXPECT_LT(hip, 125.0) << time;
      EXPECT_LT(elbow, 145.0) << time;
      // 20 degrees up, 50 down, from the foot's rest angle.
      EXPECT_GT(ankle, 10.0) << time;
      EXPECT_LT(ankle, 100.0) << time;
      // Knees bend forwards and outwards, never inwards.
      EXPECT_GT((side == "_L" ? 1.0 : -1.0) * at[joint("shin" + side)].x(), 0.08) << time;
      now.insert(now.end(), {knee, hip, ankle, elbow});
    }
    // 1,500 degrees per second is a fast kick.
    for (std::size_t i = 0; i < before.size(); ++i) EXPECT_LT(std::abs(now[i] - before[i]), 12.5) << time;
    before = now;
  }
  EXPECT_GT(deepest_knee, 60.0);
}

TEST_F(BearJump, IsTheSameLeftAndRight) {
  for (double t = 0.0; t < bear_.clips[0].duration; t += 0.1) {
    const std::vector<Vector3d> at = places(t);
    for (const std::string name : {"hand", "forearm", "shin", "foot", "toe"}) {
      Vector3d right = at[joint(name + "_R")];
      right.x() = -right.x();
      // Flesh of the left is blended in before the right's, which makes them differ by some grams.
      EXPECT_LT((at[joint(name + "_L")] - right).norm(), 1e-4) << name << " " << t;
    }
  }
}

TEST(ArmCurl, ReachesItsAnglesFromBothBindPoses) {
  const auto elbow_of = [](const rig::Character& arm, const rig::Clip* clip, double time) {
    const auto joints = rig::joint_transforms_at(arm, clip, time);
    const auto at = [&](std::size_t j) { return Vector3d(joints[j].topRightCorner<3, 1>()); };
    EXPECT_EQ(arm.skeleton.at(2).name, "forearm");
    const Vector3d upper = at(2) - at(1), lower = at(3) - at(2);
    EXPECT_GE(upper.cross(lower).z(), -1e-12) << "the forearm folds up";
    return degrees * std::acos(std::clamp(upper.normalized().dot(lower.normalized()), -1.0, 1.0));
  };
  for (const auto& [name, bind] : {std::pair("arm", 0.0), std::pair("arm-bent", 46.0)}) {
    const rig::Character arm = made::make_character(name);
    // acos near 1 halves the number of digits.
    EXPECT_NEAR(elbow_of(arm, nullptr, 0.0), bind, 1e-5) << name;
    EXPECT_NEAR(elbow_of(arm, &arm.clips.at(0), 0.0), 0.0, 1e-5) << name;
    EXPECT_NEAR(elbow_of(arm, &arm.clips.at(0), 2.0), 160.0, 1e-5) << name;
    EXPECT_NEAR(elbow_of(arm, &arm.clips.at(0), arm.clips[0].duration), 0.0, 1e-5) << name;
  }
}

TEST(MadeMotion, CurvesStayBetweenTheirKeys) {
  const made::Curve curve({{0.0, 1.0}, {0.5, 3.0}, {0.6, 9.0}, {2.0, 9.5}, {2.5, -1.0}});
  for (const auto& [from, to, low, high] : {std::tuple(0.0, 0.5, 1.0, 3.0), std::tuple(0.5, 0.6, 3.0, 9.0),
                                            std::tuple(0.6, 2.0, 9.0, 9.5), std::tuple(2.0, 2.5, -1.0, 9.5)})
    for (double u = 0.0; u <= 1.0; u += 0.02) {
      EXPECT_GE(curve.at(from + u * (to - from)), low - 1e-12);
      EXPECT_LE(curve.at(from + u * (to - from)), high + 1e-12);
    }
  EXPECT_EQ(curve.at(-1.0), 1.0);
  EXPECT_EQ(curve.at(9.0), -1.0);
}

// Compared with its given derivatives, by finite differences.
TEST(MadeMotion, MotionHasItsKeysVelocityAndAcceleration) {
  const std::vector<made::MotionKey> keys{{0.0, 1.0, -2.0, 3.0}, {0.7, 0.5, 4.0, -9.0}, {1.0, 2.0, 0.0, 1.0}};
  constexpr double d = 1e-4;
  {
    const made::MotionKey& key = keys[1];
    const double before = made::motion_at(keys, key.time - d), at = made::motion_at(keys, key.time),
                 after = made::motion_at(keys, key.time + d);
    EXPECT_NEAR(at, key.place, 1e-12);
    // Third derivatives of a few hundred, times d squared.
    EXPECT_NEAR((after - before) / (2 * d), key.velocity, 1e-5);
    EXPECT_NEAR((after - 2 * at + before) / (d * d), key.acceleration, 0.1);
  }
}

TEST(BearBump, ThrowsTheBellyForwardAndComesBackOnItsFeet) {
  const rig::Character bear = made::make_character("bear");
  const rig::Clip& clip = bear.clips.at(1);
  EXPECT_EQ(clip.name, "bump");
  const auto place = [&](const std::string& name, double time) {
    for (std::size_t j = 0; j < bear.skeleton.size(); ++j)
      if (bear.skeleton[j].name == name)
        return Vector3d(rig::joint_transforms_at(bear, &clip, time)[j].topRightCorner<3, 1>());
    throw std::out_of_range(name);
  };
  EXPECT_LT(place("spine", 0.55).z(), place("spine", 0.0).z() - 0.03) << "it draws back";
  EXPECT_GT(place("spine", 1.05).z(), place("spine", 0.0).z() + made::bump_reach) << "hips and belly first";
  EXPECT_LT((place("hips", clip.duration) - place("hips", 0.0)).norm(), 1e-3) << "and it recovers";
  // At the keys, 120 per second, the feet reach their targets up to rounding. Halfway between keys joints
  // rotate at a constant rate, and the feet are off by a millimetre where the heels lift.
  for (const std::string toe : {"toe_L", "toe_R"})
    for (int k = 0; k <= 2 * 264; ++k)
      ASSERT_LT((place(toe, k / 240.0) - place(toe, 0.0)).norm(), k % 2 == 0 ? 1e-9 : 1e-3)
          << toe << " at " << k;
}

TEST(MadeMotion, LimbsReachTheirTargets) {
  const made::Limb leg{{0.1, 0.7, 0.0}, {0.15, 0.4, 0.03}, {0.2, 0.1, 0.0}};
  const Vector3d side(0.2, 0.0, 1.0), root(0.05, 0.6, -0.1), target(0.3, 0.12, 0.1);
  const made::LimbTurns turns = made::reach(leg, side, root, target, Vector3d(0.3, 0.0, 1.0));
  EXPECT_TRUE(turns.reaches);
  const Vector3d end = root + turns.upper * (leg.middle - leg.root) + turns.lower * (leg.end - leg.middle);
  EXPECT_LT((end - target).norm(), 1e-12);
  for (const Eigen::Matrix3d& turn : {turns.upper, turns.lower}) {
    EXPECT_LT((turn * turn.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    EXPECT_GT(turn.determinant(), 0.0);
  }
  const made::LimbTurns far = made::reach(leg, side, root, root + Vector3d(0.0, -5.0, 0.0), side);
  EXPECT_FALSE(far.reaches);
  EXPECT_NEAR(far.bend, 0.0, 1e-6);
}

}  // namespace
}  // namespace fascicle::tests
