// Parts of the skin that the rig moves rigidly: which they are, and that they ride on their joint alone.
#include "host/build/rigid_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "host/build/build.h"
#include "tests/build/made_surfaces.h"
#include "tests/build/rigid_trunk.h"
#include "tests/build/scenes.h"

namespace fascicle::tests::rigid_parts_test {
namespace {

// A different rotation and translation for each joint.
Eigen::Matrix4d pose_of(std::uint32_t joint) {
  Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
  const double angle = 0.3 + 0.4 * joint;
  pose.block<3, 3>(0, 0) =
      Eigen::AngleAxisd(angle, Vector3d(1.0, 0.5 * joint, -0.3).normalized()).toRotationMatrix();
  pose.block<3, 1>(0, 3) = Vector3d(0.1 * joint, -0.2, 0.05);
  return pose;
}

Vector3d moved(const Eigen::Matrix4d& pose, const Vector3d& p) {
  return pose.block<3, 3>(0, 0) * p + pose.block<3, 1>(0, 3);
}

// The position of a model vertex by skinning alone.
Vector3d skinned(const model::Model& m, std::uint32_t vertex) {
  Vector3d rest;
  for (int a = 0; a < 3; ++a)
    rest[a] = m.rest_origin[static_cast<std::size_t>(a)] +
              m.unit * static_cast<double>(m.rest[3 * vertex + static_cast<std::size_t>(a)]);
  Vector3d sum = Vector3d::Zero();
  for (std::uint32_t k = m.skin_offset[vertex]; k < m.skin_offset[vertex + 1]; ++k)
    sum += static_cast<double>(m.skin_weight[k]) * moved(pose_of(m.skin_joint[k]), rest);
  return sum;
}

// If all corners move by skinning, how far a render vertex is from the file's own skinning; and whether all
// corners are kinematic.
struct Ride {
  double error = 0.0;
  bool is_kinematic = true;
};
Ride ride_of(const model::Model& m, const rig::Character& c, std::uint32_t vertex) {
  Ride ride;
  Vector3d at = Vector3d::Zero(), wanted = Vector3d::Zero();
  for (std::size_t k = 0; k < 4; ++k) {
    const std::uint32_t corner = m.surface_vertex[4 * vertex + k];
    const double weight = static_cast<double>(m.surface_weight[4 * vertex + k]);
    at += weight * skinned(m, corner);
    if (weight != 0.0) ride.is_kinematic = ride.is_kinematic && m.is_kinematic(corner);
  }
  for (std::size_t k = 0; k < 8; ++k)
    wanted += c.weights[vertex][k] * moved(pose_of(c.joints[vertex][k]), c.surface.vertices[vertex]);
  ride.error = (at - wanted).norm();
  return ride;
}

// Rest positions are floats of a 1.4 m body, with errors of about 1e-7 m; weights on a carrier reach 2.
constexpr double ride_tolerance = 2e-6;

TEST(RigidParts, APlateRidesOnItsJointAlone) {
  const scene::Scene scene = scene_of(trunk_with({plate()}));
  const auto& character = std::get<rig::Character>(scene.geometry);
  build::Report report;
  const model::Model m = build::build_model(scene, report, with_mesher());
  ASSERT_EQ(report.rigid_parts.size(), 1u);
  EXPECT_EQ(report.rigid_parts[0].name, "Plate / Steel");
  EXPECT_EQ(report.rigid_parts[0].joint, "PlateJoint");
  EXPECT_EQ(report.rigid_parts[0].vertices, 8u);
  const rig::SurfacePart& part = character.parts[1];
  for (std::uint32_t v = part.first_vertex; v < part.first_vertex + part.vertex_count; ++v) {
    const Ride ride = ride_of(m, character, v);
    EXPECT_TRUE(ride.is_kinematic) << v;
    EXPECT_LT(ride.error, ride_tolerance) << v;
  }
  // The flesh behind the plate is held; the flesh of the back is free.
  std::size_t held = 0, free = 0;
  for (std::uint32_t v = 0; v < part.first_vertex; ++v) {
    const Vector3d& p = character.surface.vertices[v];
    const bool is_kinematic = ride_of(m, character, v).is_kinematic;
    if (std::abs(p[1] - 0.9) < 0.05 && p[2] > 0.19) {
      EXPECT_TRUE(is_kinematic) << p.transpose();
      ++held;
    }
    if (std::abs(p[1] - 0.4) < 0.15) free += is_kinematic ? 0 : 1;
  }
  EXPECT_GT(held, 0u);
  EXPECT_GT(free, 50u);
  // Only the plate's carrier is a separate part, and that is not worth a warning.
  for (const build::Warning& warning : report.warnings)
    EXPECT_EQ(warning.text.find("do not touch"), std::string::npos) << warning.text;
}

// The control: the same plate, declared simulated, is flesh.
TEST(RigidParts, APlateThatIsSimulatedIsFlesh) {
  scene::Scene scene = scene_of(trunk_with({plate()}));
  scene.skeleton.simulated = {"PlateJoint"};
  EXPECT_EQ(count_rigid(scene), 0u);
}

TEST(RigidParts, AnEvenBlendIsRigidAndAnUnevenOneIsNot) {
  Piece horn = plate();
  horn.weights = {{chest, 0.55}, {pelvis, 0.45}};
  scene::Scene scene = scene_of(trunk_with({horn}));
  EXPECT_EQ(count_rigid(scene), 8u);
  const auto& character = std::get<rig::Character>(scene.geometry);
  const model::Model m = build_with(scene, with_mesher());
  for (std::uint32_t v = character.parts[1].first_vertex; v < character.surface.vertices.size(); ++v)
    EXPECT_LT(ride_of(m, character, v).error, ride_tolerance) << v;

  rig::Character uneven = character;
  uneven.weights.back() = {0.4, 0.6};
  EXPECT_EQ(count_rigid(scene_of(uneven)), 0u);
}

// The carriers that a part's vertices ride on, each by its corners.
std::set<std::array<std::uint32_t, 4>> carriers_of(const model::Model& m, const rig::SurfacePart& part) {
  std::set<std::array<std::uint32_t, 4>> carriers;
  for (std::size_t v = part.first_vertex; v < part.first_vertex + part.vertex_count; ++v) {
    std::array<std::uint32_t, 4> corners{};
    for (std::size_t k = 0; k < 4; ++k) corners[k] = m.surface_vertex[4 * v + k];
    carriers.insert(corners);
  }
  return carriers;
}

// Noise in the weights of a helmet: the part moves by their mean, and keeps its shape.
TEST(RigidParts, AnAlmostEvenBlendMovesAsOne) {
  Piece horn = plate();
  horn.weights = {{chest, 0.5}, {pelvis, 0.5}};
  rig::Character character = trunk_with({horn});
  const rig::SurfacePart part = character.parts[1];
  const std::array<double, 8> noise{0.03, -0.01, 0.02, -0.03, 0.01, -0.02, 0.04, -0.04};
  for (std::size_t k = 0; k < noise.size(); ++k)
    character.weights[part.first_vertex + k] = {0.5 + noise[k], 0.5 - noise[k]};
  const scene::Scene scene = scene_of(character);
  EXPECT_EQ(count_rigid(scene), 8u);
  const model::Model m = build_with(scene, with_mesher());
  const auto carriers = carriers_of(m, part);
  ASSERT_EQ(carriers.size(), 1u);
  for (const std::uint32_t corner : *carriers.begin()) {
    float sum = 0.0f;
    for (std::uint32_t k = m.skin_offset[corner]; k < m.skin_offset[corner + 1]; ++k) sum += m.skin_weight[k];
    EXPECT_EQ(sum, 1.0f);
  }
  for (std::size_t k = 0; k < noise.size(); ++k) character.weights[part.first_vertex + k] = {0.5, 0.5};
  for (std::uint32_t v = part.first_vertex; v < part.first_vertex + part.vertex_count; ++v)
    EXPECT_LT(ride_of(m, character, v).error, ride_tolerance) << v;
}

// Each of a hard part's vertices may have weights of its own, and a carrier each would cost contact the
// square of their number. They share one, and stay within the hundredth that a hard part may be off.
TEST(RigidParts, AHardPartOfThousandsOfWeightsMovesAsOne) {
  Piece knob{ball(0.05, 80), {0, 0.9, trunk_radius + 0.1}, {{plate_joint, 1.0}}, "Knob", ""};
  rig::Character character = trunk_with({knob});
  const rig::SurfacePart part = character.parts[1];
  ASSERT_GT(part.vertex_count, 3000u);
  for (std::size_t k = 0; k < part.vertex_count; ++k) {
    const double off = 0.01 * static_cast<double>(k) / part.vertex_count;
    character.joints[part.first_vertex + k] = {plate_joint, chest};
    character.weights[part.first_vertex + k] = {1.0 - off, off};
  }
  const scene::Scene scene = scene_of(character);
  EXPECT_EQ(count_rigid(scene), part.vertex_count);
  const model::Model m = build_with(scene, with_mesher());
  EXPECT_EQ(carriers_of(m, part).size(), 1u);
  // The two joints' poses move the knob by less than a metre apart.
  for (std::uint32_t v = part.first_vertex; v < part.first_vertex + part.vertex_count; ++v)
    EXPECT_LT(ride_of(m, character, v).error, 0.01) << v;
}

// The control: requested skin is not one rigid part, and keeps its weights to a 64th.
TEST(RigidParts, ThousandsOfWeightsThatAreAskedForShareCarriers) {
  Piece knob{ball(0.05, 80), {0, 0.9, trunk_radius + 0.1}, {{plate_joint, 1.0}}, "Knob", ""};
  rig::Character character = trunk_with({knob});
  const rig::SurfacePart part = character.parts[1];
  for (std::size_t k = 0; k < part.vertex_count; ++k) {
    const double off = static_cast<double>(k) / part.vertex_count;
    character.joints[part.first_vertex + k] = {plate_joint, chest};
    character.weights[part.first_vertex + k] = {1.0 - off, off};
  }
  scene::Scene scene = scene_of(character);
  scene.skeleton.rigid = {"Knob"};
  const model::Model m = build_with(scene, with_mesher());
  EXPECT_EQ(carriers_of(m, part).size(), 65u);
  // A carrier's weights are off by at most a 64th, and the two joints' poses are less than a metre apart.
  for (std::uint32_t v = part.first_vertex; v < part.first_vertex + part.vertex_count; ++v)
    EXPECT_LT(ride_of(m, character, v).error, 1.0 / 64.0) << v;
}

TEST(RigidParts, OnePieceOfHardWeightsIsFlesh) {
  EXPECT_EQ(count_rigid(scene_of(trunk_with({}, true))), 0u);
}

// The trunk with the front patch from `low` to `high` cut out and put back with another material.
scene::Scene inlaid_trunk(double low, double high, const std::string& material,
                          double weight_of_chest = 1.0) {
  rig::Character c = trunk_with({});
  Piece inlay{
      {}, Vector3d::Zero(), {{chest, weight_of_chest}, {pelvis, 1.0 - weight_of_chest}}, "Body", material};
  std::map<std::uint32_t, std::uint32_t> number;
  std::vector<std::array<std::uint32_t, 3>> left;
  for (const auto& t : c.surface.triangles) {
    const bool is_inlaid = std::all_of(t.begin(), t.end(), [&](std::uint32_t v) {
      const Vector3d& p = c.surface.vertices[v];
      return p[1] > low && p[1] < high && p[2] > 0.9 * trunk_radius;
    });
    if (!is_inlaid) {
      left.push_back(t);
      continue;
    }
    std::array<std::uint32_t, 3> corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [entry, is_new] =
          number.try_emplace(t[k], static_cast<std::uint32_t>(inlay.surface.vertices.size()));
      if (is_new) inlay.surface.vertices.push_back(c.surface.vertices[t[k]]);
      corners[k] = entry->second;
    }
    inlay.surface.triangles.push_back(corners);
  }
  c.surface.triangles = left;
  c.parts[0].triangle_count = static_cast<std::uint32_t>(left.size());
  add(c, inlay);
  return scene_of(c);
}

TEST(RigidParts, AToothThatIsModelledIntoTheSkinIsRigid) {
  const scene::Scene scene = inlaid_trunk(1.08, 1.22, "Tooth");
  const auto& character = std::get<rig::Character>(scene.geometry);
  const Found found = find_in(scene);
  ASSERT_EQ(found.rigid.report.size(), 1u);
  EXPECT_EQ(found.rigid.report[0].name, "Body / Tooth");
  EXPECT_EQ(found.rigid.report[0].joint, "Chest");
  EXPECT_EQ(count_rigid(scene), character.parts[1].vertex_count);
  // It is part of the skin, not separate.
  EXPECT_EQ(std::count(found.rigid.is_apart.begin(), found.rigid.is_apart.end(), char{1}), 0);
  const model::Model m = build_with(scene, with_mesher());
  for (std::uint32_t v = character.parts[1].first_vertex; v < character.surface.vertices.size(); ++v)
    EXPECT_LT(ride_of(m, character, v).error, ride_tolerance) << v;
}

// The controls: with blended weights, with a large patch, or without a separate material, it is flesh.
TEST(RigidParts, OtherPatchesOfTheSkinAreFlesh) {
  EXPECT_EQ(count_rigid(inlaid_trunk(1.08, 1.22, "Tooth", 0.8)), 0u);
  EXPECT_EQ(count_rigid(inlaid_trunk(0.95, 1.35, "Bib")), 0u);
  scene::Scene same = inlaid_trunk(1.08, 1.22, "Skin");
  std::get<rig::Character>(same.geometry).parts.pop_back();
  EXPECT_EQ(count_rigid(same), 0u);
}

TEST(RigidParts, LargePartsAreFleshUnlessAllAreHard) {
  // As large as the trunk, so half of the skin.
  Piece twin{{}, {1, 0, 0}, {{plate_joint, 1.0}}, "Twin", ""};
  twin.surface = trunk_with({}).surface;
  EXPECT_EQ(count_rigid(scene_of(trunk_with({twin}))), 0u);
  // A robot: the trunk follows the pelvis, and its twin follows another joint.
  rig::Character robot = trunk_with({twin});
  for (std::size_t v = 0; v < robot.parts[0].vertex_count; ++v) robot.weights[v] = {1.0, 0.0};
  const scene::Scene scene = scene_of(robot);
  EXPECT_EQ(count_rigid(scene), robot.surface.vertices.size());
  build::Report report;
  const model::Model m = build::build_model(scene, report, with_mesher());
  EXPECT_EQ(m.vertex_count, 8u);
  ASSERT_EQ(report.rigid_parts.size(), 2u);
  EXPECT_NE(report.rigid_parts[0].reason.find("robot"), std::string::npos);
  // Warnings about flesh, such as empty layers or parts that do not touch, make no sense here.
  for (const build::Warning& warning : report.warnings) ADD_FAILURE() << warning.text;
  for (std::uint32_t v = 0; v < robot.surface.vertices.size(); ++v)
    EXPECT_LT(ride_of(m, robot, v).error, ride_tolerance) << v;
}

// The control: flesh that becomes rigid only through a bone layer's shapes gives a warning.
TEST(RigidParts, FleshThatLayersMakeRigidIsWarnedOf) {
  scene::Scene scene = scene_of(trunk_with({plate()}));
  scene.layers[1].where = {scene::Everywhere{}};
  build::Report report;
  const model::Model m = build::build_model(scene, report, with_mesher());
  for (std::uint32_t i = 0; i < m.vertex_count; ++i) ASSERT_TRUE(m.is_kinematic(i));
  EXPECT_TRUE(std::any_of(report.warnings.begin(), report.warnings.end(), [](const build::Warning& warning) {
    return warning.text == "layers.flesh: holds no vertex";
  }));
}

// The plate comes first in the file and has a seam, and the trunk is open. Vertices of the trunk's rim are
// reported by the file's numbers, and the plate's vertices are counted as in the file.
TEST(RigidParts, VerticesAreCountedAsInTheFile) {
  rig::Character c = trunk_with({});
  Piece trunk{c.surface, Vector3d::Zero(), {{pelvis, 1.0}}, "Body", "Skin"}, seamed = plate();
  const auto cut = trunk.surface.triangles[trunk.surface.triangles.size() / 2];
  trunk.surface.triangles.erase(trunk.surface.triangles.begin() +
                                static_cast<std::ptrdiff_t>(trunk.surface.triangles.size() / 2));
  seamed.surface.vertices.push_back(seamed.surface.vertices[seamed.surface.triangles[0][0]]);
  seamed.surface.triangles[0][0] = 8;
  rig::Character both;
  both.skeleton = c.skeleton;
  add(both, seamed);
  add(both, trunk);
  for (std::size_t v = 0; v < c.weights.size(); ++v) {
    both.joints[9 + v] = c.joints[v];
    both.weights[9 + v] = c.weights[v];
  }
  build::Report report;
  build::build_model(scene_of(both), report, with_mesher());
  ASSERT_EQ(report.rigid_parts.size(), 1u);
  EXPECT_EQ(report.rigid_parts[0].vertices, 9u);
  const build::CageReport& cage = report.fill.cage;
  EXPECT_EQ(cage.findings.open_edges.count, 3u);
  std::vector<std::uint32_t> rim{9 + cut[0], 9 + cut[1], 9 + cut[2]};
  ASSERT_FALSE(cage.findings.open_edges.vertices.empty());
  for (const std::uint32_t v : cage.findings.open_edges.vertices)
    EXPECT_TRUE(std::find(rim.begin(), rim.end(), v) != rim.end()) << v;
  ASSERT_EQ(cage.ends.vertex.size(), 1u);
  EXPECT_TRUE(std::find(rim.begin(), rim.end(), cage.ends.vertex[0]) != rim.end()) << cage.ends.vertex[0];
}

TEST(RigidParts, CanBeAskedFor) {
  Piece soft = plate();
  soft.weights = {{chest, 0.5}, {plate_joint, 0.5}};
  rig::Character character = trunk_with({soft});
  character.weights.back() = {0.9, 0.1};
  EXPECT_EQ(count_rigid(scene_of(character)), 0u);
  for (const char* name : {"Plate", "Steel"}) {
    scene::Scene scene = scene_of(character);
    scene.skeleton.rigid = {name};
    EXPECT_EQ(count_rigid(scene), 8u) << name;
  }
  scene::Scene scene = scene_of(character);
  scene.skeleton.rigid = {"PlateJoint"};
  EXPECT_EQ(count_rigid(scene), 7u);  // the last vertex has only a weight of 0.1
  scene.skeleton.rigid = {"Stel"};
  expect_refusal([&] { find_in(scene); }, "did you mean Steel");
  // Painted: a patch of the trunk, which stays connected to it.
  rig::PaintedAttribute paint{"_RIGID", 1, {}};
  for (const Vector3d& p : character.surface.vertices)
    paint.values.push_back(p[1] > 1.2 && p[2] < 0.3 && std::abs(p[0]) < 0.5 ? 1.0 : 0.0);
  character.painted = {paint};
  const scene::Scene painted = scene_of(character);
  const Found found = find_in(painted);
  EXPECT_GT(std::count(found.rigid.is_rigid.begin(), found.rigid.is_rigid.end(), char{1}), 20);
  EXPECT_EQ(std::count(found.rigid.is_apart.begin(), found.rigid.is_apart.end(), char{1}), 0);
  const model::Model m = build_with(painted, with_mesher());
  for (std::uint32_t v = 0; v < character.surface.vertices.size(); ++v) {
    if (paint.values[v] == 0.0) continue;
    const Ride ride = ride_of(m, character, v);
    EXPECT_TRUE(ride.is_kinematic);
    EXPECT_LT(ride.error, ride_tolerance) << v;
  }
}

}  // namespace
}  // namespace fascicle::tests::rigid_parts_test
