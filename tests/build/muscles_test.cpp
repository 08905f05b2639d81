// Which regions of the built-in arm belong to its muscles, and their bulge and shear.
#include "host/build/muscles.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "host/scene/scene_file.h"
#include "tests/build/scenes.h"

namespace fascicle::tests {
namespace {

using Eigen::Vector3d;

constexpr double upper_arm_length = 0.3;
const std::string upper_arm = "[muscle.upper-arm]\njoint = \"forearm\"\n";

struct BuiltArm {
  scene::Scene scene;
  model::Model model;
  build::Report report;
};

// The built-in arm's body with the given muscles.
BuiltArm arm_with(const std::string& muscles, const std::vector<std::string>& set = {}) {
  BuiltArm arm;
  std::string text;
  for (const scene::BuiltinScene& builtin : scene::builtin_scenes())
    if (builtin.name == "arm") text = builtin.text;
  const std::size_t first = text.find("[muscle."), end = text.find("[solver]");
  const std::string changed = text.substr(0, first) + muscles + text.substr(end);
  arm.scene = scene::parse_scene({"arm", "test", changed, {}}, {.set = set});
  arm.model = build::build_model(arm.scene, arm.report, with_mesher());
  return arm;
}

Vector3d place(const model::Model& m, std::uint32_t i) {
  return m.unit * Vector3d(m.rest[3 * i], m.rest[3 * i + 1], m.rest[3 * i + 2]) +
         Vector3d(m.rest_origin[0], m.rest_origin[1], m.rest_origin[2]);
}

TEST(Muscles, TakeTheBulgeAlongTheirBone) {
  const BuiltArm arm = arm_with(upper_arm);
  const model::Model& m = arm.model;
  ASSERT_NO_THROW(model::check_model(m));
  ASSERT_EQ(m.muscle_count, 1u);
  std::size_t bulging = 0;
  for (std::uint32_t r = 0; r < m.vertex_count; ++r) {
    const double x = place(m, r).x();
    const std::uint32_t entries = m.muscle_offset[r + 1] - m.muscle_offset[r];
    ASSERT_LE(entries, 1u);
    if (entries == 0) continue;
    EXPECT_FALSE(m.is_kinematic(r));
    EXPECT_GT(x, 0.0);
    EXPECT_LT(x, upper_arm_length);
    const shader::RegionMuscle& entry = m.region_muscle[m.muscle_offset[r]];
    // Gain 1.5; beta is 1 in muscle and 0 in fat; all floats.
    const double angle = std::numbers::pi * x / upper_arm_length;
    const double expected = 1.5 * (std::sin(angle) - std::sin(3.0 * angle)) / 2.0 * m.beta[r];
    EXPECT_NEAR(entry.bulge, expected, 1e-6);
    EXPECT_EQ(entry.shear, 0.0f);
    bulging += entry.bulge != 0.0f ? 1u : 0u;
  }
  EXPECT_GT(bulging, 300u);
}

TEST(Muscles, FramesLeadAwayFromTheBoneAndAcrossTheFibre) {
  const BuiltArm arm = arm_with(upper_arm);
  const model::Model& m = arm.model;
  for (std::uint32_t r = 0; r < m.vertex_count; ++r) {
    if (m.muscle_offset[r] == m.muscle_offset[r + 1]) continue;
    const shader::RegionFrame& f = m.region_frame[r];
    const Vector3d n(f.normal_x, f.normal_y, f.normal_z), axis(f.axis_x, f.axis_y, f.axis_z),
        around(f.around_x, f.around_y, f.around_z);
    const Vector3d fibre(m.fibre[3 * r], m.fibre[3 * r + 1], m.fibre[3 * r + 2]);
    EXPECT_EQ(axis, Vector3d::UnitX());
    EXPECT_NEAR(n.norm(), 1.0, 1e-6);  // floats
    EXPECT_NEAR(n.dot(fibre), 0.0, 1e-6);
    EXPECT_NEAR(around.norm(), 1.0, 1e-6);
    EXPECT_NEAR(around.dot(axis), 0.0, 1e-6);
    const Vector3d radial(0.0, place(m, r).y(), place(m, r).z());
    EXPECT_GT(n.dot(radial), 0.0);
    EXPECT_NEAR(around.dot(axis.cross(radial.normalized())), 1.0, 1e-5);  // positions are floats too
  }
}

TEST(Muscles, TheProfileThinsTheEnds) {
  EXPECT_NEAR(build::muscle_profile(0.0), 0.0, 1e-15);
  EXPECT_NEAR(build::muscle_profile(0.5), 1.0, 1e-15);
  EXPECT_NEAR(build::muscle_profile(0.25), 0.0, 1e-15);
  EXPECT_LT(build::muscle_profile(0.1), -0.2);
}

TEST(Muscles, ShareRegionsAndJoints) {
  const BuiltArm arm = arm_with(upper_arm + "layer = \"muscle\"\n" +
                                "[muscle.second]\njoint = \"forearm\"\ngain = -0.5\n"
                                "where = { above = { value = 0.0 } }\n"
                                "[muscle.twisted]\nbone = \"forearm\"\ntwist = 0.5\n");
  const model::Model& m = arm.model;
  ASSERT_EQ(m.muscle_count, 3u);
  std::set<std::vector<std::uint32_t>> sets;
  for (std::uint32_t r = 0; r < m.vertex_count; ++r) {
    std::vector<std::uint32_t> muscles;
    for (std::uint32_t e = m.muscle_offset[r]; e < m.muscle_offset[r + 1]; ++e) {
      const shader::RegionMuscle& entry = m.region_muscle[e];
      muscles.push_back(entry.muscle);
      if (entry.muscle == 0) {
        EXPECT_EQ(m.layers[m.layer_of(r)].name, "muscle");
      }
      if (entry.muscle == 1) {
        EXPECT_GE(place(m, r).y(), -1e-6);
      }
      if (entry.muscle == 2) {
        // Half of the distance from the axis, divided by the forearm's length of 0.26 m.
        const double distance = Vector3d(0.0, place(m, r).y(), place(m, r).z()).norm();
        EXPECT_NEAR(entry.shear, 0.5 * distance / 0.26, 1e-5);
      }
    }
    sets.insert(muscles);
  }
  EXPECT_TRUE(sets.contains({0, 1})) << "both, in ascending order";
  EXPECT_TRUE(sets.contains({0}));
  EXPECT_TRUE(sets.contains({2}));
}

TEST(Muscles, AreRefusedWhereTheyHoldNothing) {
  try {
    arm_with(upper_arm + "where = { sphere = { center = [9.0, 0.0, 0.0], radius = 0.1 } }\n");
    ADD_FAILURE();
  } catch (const scene::SceneError& error) {
    EXPECT_NE(std::string(error.what()).find("muscle.upper-arm: holds no vertex"), std::string::npos)
        << error.what();
  }
}

TEST(Muscles, ThatCannotActAreWarnedOf) {
  const auto warns = [](const BuiltArm& arm, const std::string& text) {
    return std::any_of(arm.report.warnings.begin(), arm.report.warnings.end(),
                       [&](const auto& warning) { return warning.text.find(text) != std::string::npos; });
  };
  const std::string no_fibre = "muscle.upper-arm: none of its flesh has a fibre";
  const std::string not_keyed = "muscle.upper-arm: the clip does not move its contraction_channel";
  const BuiltArm acting = arm_with(upper_arm);
  EXPECT_FALSE(warns(acting, no_fibre));
  EXPECT_FALSE(warns(acting, not_keyed));
  EXPECT_TRUE(warns(arm_with(upper_arm, {"layers.muscle.beta=0"}), no_fibre));
  EXPECT_TRUE(warns(arm_with(upper_arm + "contraction_channel = \"hand.scale.y\"\n"), not_keyed));
  EXPECT_FALSE(warns(arm_with(upper_arm + "contraction = [[0, 0], [1, 0.2]]\n"), not_keyed));
}

}  // namespace
}  // namespace fascicle::tests
