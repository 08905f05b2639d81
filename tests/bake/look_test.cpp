// The look score on simple bodies: each measure is red where it should be, with the value that geometry
// gives, and green otherwise.
#include "host/bake/look.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "host/bake/look_body.h"
#include "host/bake/look_report.h"
#include "host/bake/triangle_tree.h"
#include "tests/bake/fake_bakes.h"
#include "tests/support/test_models.h"

namespace fascicle::tests {
namespace {

using bake::Look;
using bake::LookBody;
using bake::LookMeasure;
using bake::LookScore;
using bake::LookScores;
using Eigen::Vector3d;

using Map = std::function<Vector3d(const Vector3d&)>;

constexpr double bar_length = 2.0, bar_side = 0.5;  // m

// Along x, with two joints; every render vertex is a model vertex.
model::Model bar_with_skin() {
  model::Model model = make_model(kuhn_bar(16, 4, 4, 0.125));
  add_skeleton(model);
  for (float& weight : model.surface_weight) weight = weight > 0.5f ? 1.0f : 0.0f;
  return model;
}

Vector3d still(const Vector3d& p) {
  return p;
}

Vector3d rest_at(const std::vector<float>& values, std::size_t i) {
  return {double{values[3 * i]}, double{values[3 * i + 1]}, double{values[3 * i + 2]}};
}

std::vector<float> moved(const std::vector<float>& points, const Map& map) {
  std::vector<float> result;
  for (std::size_t i = 0; i < points.size() / 3; ++i)
    for (const double x : map(rest_at(points, i))) result.push_back(static_cast<float>(x));
  return result;
}

model::Frame frame_of(const model::Model& model, const Map& flesh, const Map& skin = still,
                      std::uint64_t index = 0) {
  return {.index = index,
          .origin = {},
          .positions = moved(model.rest, flesh),
          .velocities = {},
          .surface = {},
          .skinned = moved(model.rest, skin)};
}

const LookScore& score_of(const LookScores& scores, LookMeasure measure) {
  return scores.of[static_cast<std::size_t>(measure)];
}

class LookAtBar : public testing::Test {
 protected:
  LookScores look(const Map& flesh, const Map& skin = still) const {
    return Look(model_, body_, 60.0).of(frame_of(model_, flesh, skin));
  }
  LookScore look(LookMeasure measure, const Map& flesh, const Map& skin = still) const {
    return score_of(look(flesh, skin), measure);
  }

  const model::Model model_ = bar_with_skin();
  const LookBody body_ = bake::look_body(model_, nullptr);
};

TEST_F(LookAtBar, FindsNothingWhereFleshIsWhereSkinningIs) {
  const Eigen::AngleAxisd turn(1.0, Vector3d(1, 2, 3).normalized());
  const Map bent = [&](const Vector3d& p) -> Vector3d {
    return turn * p + Vector3d(0, 0.2 * p.x() * p.x(), 0);
  };
  const LookScores scores = look(bent, bent);
  for (const LookScore& score : scores.of) EXPECT_EQ(score.score, 0.0);
}

TEST_F(LookAtBar, IsAsThickAsItsSide) {
  std::size_t seen = 0;
  for (std::size_t i = 0; i < body_.thickness.size(); ++i) {
    const Vector3d p = rest_at(body_.rest, i);
    const auto inside = [&](double x) { return x > 0.06 && x < bar_side - 0.06; };
    if (!inside(p.z()) || p.x() < 0.2 || p.x() > bar_length - 0.2) continue;
    // Straight through, from one side to the other.
    EXPECT_NEAR(body_.thickness[i], bar_side, 1e-6) << p.transpose();
    ++seen;
  }
  EXPECT_GT(seen, 50u);
}

// Stretches the part beyond x = 1.25 to three times its length along x.
Vector3d drawn_out(const Vector3d& p) {
  return {p.x() < 1.25 ? p.x() : 1.25 + 3.0 * (p.x() - 1.25), p.y(), p.z()};
}

TEST_F(LookAtBar, StretchIsTheLongestDirection) {
  const LookScore score = look(LookMeasure::stretch, drawn_out);
  EXPECT_NEAR(score.value, 3.0, 1e-5);
  EXPECT_GT(score.score, 1.0);
  EXPECT_EQ(body_.joint_names[score.joint], "joint 1");
  // A shear by 1.5 stretches its longest direction by 1.5/2 + sqrt(1 + (1.5/2)^2).
  const LookScore sheared = look(
      LookMeasure::stretch, [](const Vector3d& p) { return Vector3d(p.x() + 1.5 * p.y(), p.y(), p.z()); });
  EXPECT_NEAR(sheared.value, 2.0, 1e-5);
}

TEST_F(LookAtBar, WhatSkinningStretchesToIsNoFault) {
  EXPECT_EQ(look(LookMeasure::stretch, drawn_out, drawn_out).score, 0.0);
  // Flesh that keeps its shape when skinning does not is no fault either.
  const Map flattened = [](const Vector3d& p) { return Vector3d(0.2 * p.x(), p.y(), p.z()); };
  EXPECT_NEAR(look(LookMeasure::stretch, still, flattened).value, 1.0, 1e-6);
}

// The far end, folded back through the middle of the bar.
Vector3d folded(const Vector3d& p) {
  if (p.x() < 1.5) return p;
  return Vector3d(0.31 + p.y(), 0.17 + 1.1 * (p.x() - 1.5), p.z() * 0.71 + 0.03);
}

TEST_F(LookAtBar, CrossingIsOfSkinThatSkinningKeepsApart) {
  const LookScore score = look(LookMeasure::crossing, folded);
  EXPECT_GT(score.score, 1.0);
  EXPECT_EQ(look(LookMeasure::crossing, folded, folded).score, 0.0);
  // Stretched skin without a fold does not cross itself.
  EXPECT_EQ(look(LookMeasure::crossing, drawn_out).score, 0.0);
}

TEST_F(LookAtBar, DistanceIsOverTheThickness) {
  const auto aside = [](double way) {
    return [way](const Vector3d& p) { return Vector3d(p.x(), p.y(), p.z() + (p.x() > 1.0 ? way : 0.0)); };
  };
  const LookScore far = look(LookMeasure::distance, aside(bar_side));
  // Skin away from the bar's long edges counts: at those edges, thickness is measured at 45 degrees and is
  // larger.
  EXPECT_NEAR(far.value, 1.0, 1e-5);
  EXPECT_GT(far.score, 1.0);
  EXPECT_EQ(body_.joint_names[far.joint], "joint 1");
  const LookScore near = look(LookMeasure::distance, aside(0.2 * bar_side));
  EXPECT_NEAR(near.value, 0.2, 1e-5);
  EXPECT_LT(near.score, 1.0);
}

TEST_F(LookAtBar, JumpIsAStepThatNoNeighbourInTimeHas) {
  const auto jumps = [&](const std::function<double(std::uint64_t)>& way, std::uint64_t frames,
                         double fps = 60.0) {
    Look look(model_, body_, fps);
    std::vector<double> values;
    for (std::uint64_t k = 0; k < frames; ++k) {
      const double z = way(k);
      const Map aside = [z](const Vector3d& p) { return Vector3d(p.x(), p.y(), p.z() + z); };
      values.push_back(score_of(look.of(frame_of(model_, aside, still, k)), LookMeasure::jump).score);
    }
    return values;
  };
  // A whole thickness in one frame.
  const auto popped = jumps([](std::uint64_t k) { return k < 4 ? 0.0 : bar_side; }, 6);
  EXPECT_EQ(popped[3], 0.0);
  EXPECT_GT(popped[4], 1.0);
  // An oscillation of half a thickness, six times a second at 60 frames a second: soft, fast and smooth.
  const auto jiggled = jumps(
      [](std::uint64_t k) {
        return 0.5 * bar_side * std::sin(2.0 * 3.14159265358979 * 0.1 * static_cast<double>(k));
      },
      30);
  EXPECT_LT(*std::max_element(jiggled.begin(), jiggled.end()), 1.0);
  EXPECT_GT(*std::max_element(jiggled.begin(), jiggled.end()), 0.1);
}

// The score must not depend on the frame rate, and coarse rates must not see more. A sudden velocity of 20
// thicknesses a second moves skin by a third of a thickness per frame at 60, by five sixths at 24.
TEST_F(LookAtBar, AKickIsNoWorseAtCoarseRates) {
  const auto kicked = [&](double fps, double limit_fps) {
    Look look(model_, body_, limit_fps);
    double worst = 0.0;
    for (std::uint64_t k = 0; k < 6; ++k) {
      const double z = 20.0 * bar_side * std::max(0.0, static_cast<double>(k) - 3.0) / fps;
      const Map aside = [z](const Vector3d& p) { return Vector3d(p.x(), p.y(), p.z() + z); };
      worst = std::max(worst, score_of(look.of(frame_of(model_, aside, still, k)), LookMeasure::jump).score);
    }
    return worst;
  };
  EXPECT_LT(kicked(60.0, 60.0), 1.0);
  EXPECT_NEAR(kicked(24.0, 24.0), kicked(60.0, 60.0), 1e-4);  // positions are floats
  // Above 60 frames a second the limit stays the same, so a step spread over two frames counts half.
  EXPECT_NEAR(kicked(120.0, 120.0), 0.5 * kicked(60.0, 60.0), 1e-4);
  EXPECT_GT(kicked(24.0, 60.0), 1.0) << "the control: a limit for another rate";
}

TEST_F(LookAtBar, ARememberedFrameCountsLikeOneLookedAt) {
  const auto frame = [&](std::uint64_t k) {
    const double z = 0.1 * static_cast<double>(k * k);
    return frame_of(
        model_, [z](const Vector3d& p) { return Vector3d(p.x(), p.y(), p.z() + z); }, still, k);
  };
  Look all(model_, body_, 60.0), resumed(model_, body_, 60.0);
  for (std::uint64_t k = 0; k < 4; ++k) all.of(frame(k));
  for (std::uint64_t k = 2; k < 4; ++k) resumed.remember(frame(k));
  const LookScores one = all.of(frame(4)), other = resumed.of(frame(4));
  EXPECT_GT(score_of(one, LookMeasure::jump).value, 0.0);
  for (std::size_t m = 0; m < bake::look_measures; ++m) EXPECT_EQ(one.of[m].value, other.of[m].value);
}

TEST_F(LookAtBar, InvertedIsBesideSkinning) {
  const Map turned = [](const Vector3d& p) { return p.x() < 1.0 ? p : Vector3d(2.0 - p.x(), p.y(), p.z()); };
  const LookScore score = look(LookMeasure::inverted, turned);
  // The far half of all tetrahedra.
  EXPECT_EQ(score.value, model_.tetrahedron_count() / 2);
  EXPECT_GT(score.score, 1.0);
  EXPECT_EQ(body_.joint_names[score.joint], "joint 1");
  EXPECT_LT(look(LookMeasure::inverted, turned, turned).score, 1.0);
}

// The bar's skin as a character's: all on joint 1, or a blend of both joints.
rig::Character character_of(const model::Model& model, bool is_hard) {
  rig::Character character;
  character.skeleton = {{.name = "hip"}, {.name = "claw"}};
  character.joints.assign(model.surface_count(), {0, 1});
  character.weights.assign(model.surface_count(), {});
  for (auto& weight : character.weights) weight = {is_hard ? 0.0 : 0.5, is_hard ? 1.0 : 0.5};
  return character;
}

TEST_F(LookAtBar, RigidPartsMayTurnButNotStrain) {
  const rig::Character hard = character_of(model_, true), soft = character_of(model_, false);
  const LookBody plate = bake::look_body(model_, &hard), flesh = bake::look_body(model_, &soft);
  ASSERT_EQ(plate.rigid.size(), 1u);
  EXPECT_EQ(plate.rigid[0].triangles.size(), model_.surface_triangle.size() / 3);
  EXPECT_TRUE(flesh.rigid.empty());
  const auto rigid = [&](const LookBody& body, const Map& map) {
    return score_of(Look(model_, body, 60.0).of(frame_of(model_, map)), LookMeasure::rigid);
  };
  const Map strained = [](const Vector3d& p) { return Vector3d(1.3 * p.x(), p.y(), p.z()); };
  const LookScore red = rigid(plate, strained);
  EXPECT_NEAR(red.value, 0.3, 1e-5);
  EXPECT_GT(red.score, 1.0);
  EXPECT_EQ(plate.joint_names[red.joint], "claw");
  EXPECT_EQ(rigid(flesh, strained).score, 0.0);
  const Eigen::AngleAxisd turn(2.0, Vector3d(3, 1, 2).normalized());
  // A few times the rounding of a float, over an edge of 1/8.
  EXPECT_LT(rigid(plate, [&](const Vector3d& p) -> Vector3d { return turn * p; }).value, 1e-5);
}

// Skin that is partly soft has no rigid part.
TEST_F(LookAtBar, ARigidPartIsOfOneObject) {
  rig::Character character = character_of(model_, true);
  const std::uint32_t half = model_.surface_count() / 2;
  // The first half of the vertices is soft.
  for (std::uint32_t v = 0; v < half; ++v) character.weights[v] = {0.5, 0.5};
  EXPECT_TRUE(bake::look_body(model_, &character).rigid.empty());
}

// Compared with all pairs, each tested by intersecting the edges of one triangle with the other.
TEST(TriangleTree, FindsThePairsThatCross) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> place(0.0f, 1.0f), small(-0.15f, 0.15f);
  std::vector<float> positions;
  std::vector<std::uint32_t> triangles, places;
  for (std::uint32_t t = 0; t < 150; ++t) {
    const float x = place(random), y = place(random), z = place(random);
    for (std::uint32_t k = 0; k < 3; ++k) {
      positions.insert(positions.end(), {x + small(random), y + small(random), z + small(random)});
      triangles.push_back(3 * t + k);
      places.push_back(3 * t + k);
    }
  }
  const auto corner = [&](std::uint32_t t, std::size_t k) { return rest_at(positions, 3 * t + k); };
  // Whether the edge p q meets the triangle, by barycentric coordinates of its intersection with the plane.
  const auto meets = [&](const Vector3d& p, const Vector3d& q, std::uint32_t t) {
    Eigen::Matrix3d m;
    m << corner(t, 1) - corner(t, 0), corner(t, 2) - corner(t, 0), p - q;
    const Vector3d at = m.inverse() * (p - corner(t, 0));
    return at[0] > 0 && at[1] > 0 && at[0] + at[1] < 1 && at[2] > 0 && at[2] < 1;
  };
  const auto expected = [&] {
    std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;
    for (std::uint32_t a = 0; a < 150; ++a)
      for (std::uint32_t b = a + 1; b < 150; ++b)
        for (std::size_t k = 0; k < 3; ++k)
          if (meets(corner(a, k), corner(a, (k + 1) % 3), b) ||
              meets(corner(b, k), corner(b, (k + 1) % 3), a))
            pairs.insert({a, b});
    return pairs;
  };
  const auto found = [](const bake::TriangleTree& tree) {
    const auto pairs = tree.crossings();
    return std::set<std::pair<std::uint32_t, std::uint32_t>>(pairs.begin(), pairs.end());
  };
  bake::TriangleTree tree(triangles, places, positions);
  EXPECT_GT(expected().size(), 20u);
  EXPECT_EQ(found(tree), expected());
  // The same after all vertices have moved.
  for (float& x : positions) x += small(random);
  tree.fit(positions);
  EXPECT_EQ(found(tree), expected());
  // For a subset, only the pairs within it.
  std::vector<std::uint8_t> asked(150);
  for (std::uint32_t t = 0; t < 150; ++t) asked[t] = t % 3 != 0;
  auto among = expected();
  std::erase_if(among, [&](const auto& pair) { return !asked[pair.first] || !asked[pair.second]; });
  const auto some = tree.crossings(asked);
  EXPECT_EQ((std::set<std::pair<std::uint32_t, std::uint32_t>>(some.begin(), some.end())), among);
  EXPECT_GT(among.size(), 5u);
  EXPECT_LT(among.size(), expected().size());
  // Without the pairs within a subset, whether or not the subset occupies whole leaves.
  for (const bool apart : {true, false}) {
    std::vector<std::uint8_t> known(150);
    for (std::uint32_t t = 0; t < 150; ++t) known[t] = apart ? corner(t, 0).x() < 0.5 : t % 3 != 0;
    auto others = expected();
    std::erase_if(others, [&](const auto& pair) { return known[pair.first] && known[pair.second]; });
    const auto left = tree.crossings({}, known);
    EXPECT_EQ((std::set<std::pair<std::uint32_t, std::uint32_t>>(left.begin(), left.end())), others);
    EXPECT_GT(others.size(), 5u);
    EXPECT_LT(others.size(), expected().size());
  }
  // Triangles that share a corner do not cross.
  const auto [a, b] = *expected().begin();
  places[3 * a] = places[3 * b + 1];
  EXPECT_FALSE(found(bake::TriangleTree(triangles, places, positions)).contains({a, b}));
}

TEST(LookReport, SaysWhatWhereAndWhen) {
  const TemporaryFolder folder;
  const model::Model model = bar_with_skin();
  std::string text =
      "frame,look,worst_joint,look_stretch,look_crossing,look_distance,look_rigid,look_jump,look_inverted\n";
  text +=
      "0,0.2,\"joint, 0\",0.2,0,0,0,0,0\n1,1.5,joint 1,1.25,0,0,0,0,1.5\n2,1.25,joint 1,1.25,0,0,0,0,0.5\n";
  write_text(folder / "metrics.csv", text);
  const auto frame_at = [&](std::uint64_t k) {
    return frame_of(model, k == 1 ? Map(drawn_out) : Map(still), still, k);
  };
  const auto summary = bake::look_summary(folder / "", model, nullptr, 60.0, frame_at);
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->worst, 1.5);
  EXPECT_EQ(summary->frame, 1u);
  EXPECT_EQ(summary->joint, "joint 1");
  EXPECT_EQ(summary->cause, "inverted");
  EXPECT_EQ(summary->frames_over, 2u);
  ASSERT_EQ(summary->warnings.size(), 2u);
  EXPECT_TRUE(contains(summary->warnings[0], "inside out"));
  EXPECT_TRUE(
      contains(summary->warnings[1], "look: frame 1: the skin at joint \"joint 1\" is stretched to 3 times"));
  EXPECT_TRUE(contains(summary->warnings[1], "2 frames are over"));
}

// The file may be a stranger's: a bake that is resumed reads it.
TEST(LookReport, IsNothingWithoutAColumn) {
  const TemporaryFolder folder;
  const model::Model model = bar_with_skin();
  const std::vector<std::string> columns{"look",          "worst_joint", "look_stretch", "look_crossing",
                                         "look_distance", "look_rigid",  "look_jump",    "look_inverted"};
  for (const std::string& missing : columns) {
    std::string header = "frame", row = "0";
    for (const std::string& column : columns)
      if (column != missing) {
        header += "," + column;
        row += ",2";
      }
    write_text(folder / "metrics.csv", header + "\n" + row + "\n");
    const auto frame_at = [&](std::uint64_t k) { return frame_of(model, still, still, k); };
    EXPECT_FALSE(bake::look_summary(folder / "", model, nullptr, 60.0, frame_at)) << missing;
  }
}

TEST(LookReport, CountsHaveWholeLimits) {
  bake::LookScore score;
  score.value = 377;
  score.limit = 321.99;
  EXPECT_TRUE(contains(bake::look_warning(bake::LookMeasure::crossing, score, "thigh", 75, 9),
                       "377 triangles, most at joint \"thigh\""));
  EXPECT_TRUE(
      contains(bake::look_warning(bake::LookMeasure::crossing, score, "thigh", 75, 9), "(limit 321; 9 "));
  EXPECT_TRUE(
      contains(bake::look_warning(bake::LookMeasure::stretch, score, "thigh", 75, 9), "(limit 321.99; 9 "));
}

// Flesh that the clip drives deep into other flesh half a second before is the reason; a lighter touch is
// not, and neither is one of long ago.
TEST(LookReport, NamesContactThatIsTooDeep) {
  const TemporaryFolder folder;
  const model::Model model = bar_with_skin();
  const double deep = 1.1 * bake::deepest_for_contact * model::extent(model);
  const auto warning_of = [&](double depth, std::uint64_t frames_before) {
    std::string text =
        "frame,contact_deepest_skinned,look,worst_joint,look_stretch,look_crossing,look_distance,look_rigid,"
        "look_jump,look_inverted\n";
    for (std::uint64_t k = 0; k <= 40; ++k)
      text += std::to_string(k) + "," + std::to_string(k + frames_before == 40 ? depth : 0.0) +
              (k == 40 ? ",1.25,joint 1,1.25,0,0,0,0,0\n" : ",0,,0,0,0,0,0,0\n");
    write_text(folder / "metrics.csv", text);
    const auto summary = bake::look_summary(folder / "", model, nullptr, 60.0, [&](std::uint64_t k) {
      return frame_of(model, k == 40 ? Map(drawn_out) : Map(still), still, k);
    });
    return summary.value().warnings.at(0);
  };
  for (const std::uint64_t before : {0, 30})
    EXPECT_TRUE(contains(warning_of(deep, before), "[contact] ignore")) << before;
  EXPECT_FALSE(contains(warning_of(deep, 31), "[contact]"));
  EXPECT_FALSE(contains(warning_of(0.8 * deep, 0), "[contact]"));
  EXPECT_TRUE(contains(warning_of(0.8 * deep, 0), "--cage-detail"));
}

TEST(LookReport, IsNothingWithoutASkeleton) {
  const TemporaryFolder folder;
  fake_bake_into(options_for(folder / "out"), short_scene(2));
  EXPECT_TRUE(manifest_in(folder / "out")["look"].is_null());
}

}  // namespace
}  // namespace fascicle::tests
