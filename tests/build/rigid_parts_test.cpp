// Parts of the skin that the rig moves rigidly, on a soft trunk: a round column from y = 0 to 1.4, with a
// plate in front of its chest.
#include "host/build/rigid_parts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "host/build/body.h"
#include "host/build/bone_choice.h"
#include "host/build/skin_weights.h"
#include "tests/build/made_surfaces.h"
#include "tests/build/scenes.h"

namespace fascicle::tests {
namespace {

using scene::Vector3d;

constexpr double trunk_radius = 0.2, trunk_height = 1.4;
constexpr std::uint32_t trunk_around = 24;
enum Joint : std::uint32_t { pelvis, chest, plate_joint };

// A part attached to the trunk: surface, position and weights.
struct Piece {
  mesh::SurfaceMesh surface;
  Vector3d place;
  std::vector<std::pair<std::uint32_t, double>> weights;
  std::string object, material;
};

Piece plate() {
  mesh::SurfaceMesh box = cube_surface(0.2);
  for (Vector3d& p : box.vertices) p[2] *= 0.1;
  return {box, {0, 0.9, trunk_radius + 0.02}, {{plate_joint, 1.0}}, "Plate", "Steel"};
}

void add(rig::Character& c, const Piece& piece) {
  rig::SurfacePart part{piece.object,
                        piece.material,
                        static_cast<std::uint32_t>(c.parts.size()),
                        static_cast<std::uint32_t>(c.surface.vertices.size()),
                        static_cast<std::uint32_t>(piece.surface.vertices.size()),
                        static_cast<std::uint32_t>(c.surface.triangles.size()),
                        static_cast<std::uint32_t>(piece.surface.triangles.size())};
  c.parts.push_back(part);
  append(c.surface, piece.surface, piece.place);
  for (std::size_t v = 0; v < piece.surface.vertices.size(); ++v) {
    std::array<std::uint32_t, 8> joints{};
    std::array<double, 8> weights{};
    for (std::size_t k = 0; k < piece.weights.size(); ++k)
      joints[k] = piece.weights[k].first, weights[k] = piece.weights[k].second;
    c.joints.push_back(joints);
    c.weights.push_back(weights);
  }
}

// The trunk's lower half follows the pelvis and its upper half the chest, with a hard border or blended over
// 0.4 m.
rig::Character trunk_with(const std::vector<Piece>& pieces, bool is_hard = false) {
  std::vector<Vector3d> line;
  for (int k = 0; k <= 28; ++k) line.emplace_back(0, trunk_height * k / 28, 0);
  rig::Character c;
  add(c, {tube(line, trunk_radius, trunk_around), Vector3d::Zero(), {{pelvis, 1.0}}, "Body", "Skin"});
  for (std::size_t v = 0; v < c.surface.vertices.size(); ++v) {
    double up = std::clamp((c.surface.vertices[v][1] - 0.5) / 0.4, 0.0, 1.0);
    if (is_hard) up = std::round(up);
    c.joints[v] = {pelvis, chest};
    c.weights[v] = {1.0 - up, up};
  }
  c.skeleton = {joint_at("Pelvis", -1, {0, 0.1, 0}), joint_at("Chest", pelvis, {0, 0.7, 0}),
                joint_at("PlateJoint", chest, {0, 0.9, 0.1})};
  for (const Piece& piece : pieces) add(c, piece);
  return c;
}

scene::Scene scene_of(rig::Character character) {
  scene::Scene scene;
  scene.name = "trunk";
  scene.source = "test";
  scene.geometry = std::move(character);
  scene.resolution = 0.05;
  scene::Layer flesh, bone;
  flesh.name = "flesh";
  bone.name = "bone";
  bone.kinematic = true;
  bone.where = {scene::Depth{0.0, 0.3}};
  scene.layers = {flesh, bone};
  return scene;
}

struct Found {
  build::RigidSkin rigid;
  build::WeldedSurface welded;
};
Found find_in(const scene::Scene& scene) {
  const auto& character = std::get<rig::Character>(scene.geometry);
  build::Report report;
  Found found;
  found.welded = build::weld(character.surface, "test", report);
  const build::SkinWeights weights = build::welded_skin_weights(character, found.welded.of_vertex,
                                                                found.welded.surface.vertices.size(), "test");
  found.rigid = build::find_rigid_parts(character, found.welded, weights, scene);
  return found;
}

std::size_t count_rigid(const scene::Scene& scene) {
  const Found found = find_in(scene);
  return static_cast<std::size_t>(
      std::count(found.rigid.is_rigid.begin(), found.rigid.is_rigid.end(), char{1}));
}

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

Piece floor(double side, double thickness, std::uint32_t joint) {
  mesh::SurfaceMesh slab = cube_surface(1.0);
  for (Vector3d& p : slab.vertices) p = p.cwiseProduct(Vector3d(side, thickness, side));
  return {slab, {0, -0.5, 0}, {{joint, 1.0}}, "Floor", "Stone"};
}

std::vector<build::Bone> bones_of(const scene::Scene& scene) {
  return build::bones_of(std::get<rig::Character>(scene.geometry), scene).bones;
}

// A floor is far larger than the body: it would hide the body's bones, whichever joint it follows.
TEST(RigidParts, AFloorIsRigidAndHidesNoBone) {
  const std::vector<build::Bone> alone = bones_of(scene_of(trunk_with({plate()})));
  ASSERT_FALSE(alone.empty());
  for (const std::uint32_t joint : {std::uint32_t{pelvis}, std::uint32_t{plate_joint}}) {
    const scene::Scene scene = scene_of(trunk_with({plate(), floor(20.0, 0.01, joint)}));
    EXPECT_EQ(count_rigid(scene), 2 * plate().surface.vertices.size());
    const std::vector<build::Bone> bones = bones_of(scene);
    ASSERT_EQ(bones.size(), alone.size()) << joint;
    for (std::size_t k = 0; k < bones.size(); ++k) {
      EXPECT_EQ(bones[k].from, alone[k].from);
      EXPECT_EQ(bones[k].to, alone[k].to);
    }
    build::Report report;
    const model::Model m = build::build_model(scene, report, with_mesher());
    EXPECT_FALSE(m.tetrahedron.empty());
    EXPECT_EQ(report.rigid_parts.back().reason, "a separate part that is large and flat, moved by one joint");
  }
}

// A floor of many triangles takes no more time for each of them. Walls that are large only without the floor
// are rigid, too, and so is a hard part of the body that is small next to all of it.
TEST(RigidParts, AFloorMayBeFineAndHaveWalls) {
  constexpr std::uint32_t across = 300;
  Piece fine{{}, {0, -0.5, 0}, {{pelvis, 1.0}}, "Floor", "Stone"};
  for (std::uint32_t x = 0; x <= across; ++x)
    for (std::uint32_t z = 0; z <= across; ++z)
      fine.surface.vertices.emplace_back(0.02 * x - 3.0, 0.0, 0.02 * z - 3.0);
  for (std::uint32_t x = 0; x < across; ++x)
    for (std::uint32_t z = 0; z < across; ++z) {
      const std::uint32_t a = x * (across + 1) + z, b = a + across + 1;
      fine.surface.triangles.push_back({a, a + 1, b + 1});
      fine.surface.triangles.push_back({a, b + 1, b});
    }
  Piece wall = floor(1.0, 1.0, pelvis);
  for (Vector3d& p : wall.surface.vertices) p = p.cwiseProduct(Vector3d(6.0, 2.5, 0.01));
  wall.place = {0, 1.0, -3.0};
  const scene::Scene scene = scene_of(trunk_with({plate(), fine, wall}));
  EXPECT_EQ(count_rigid(scene), fine.surface.vertices.size() + 2 * plate().surface.vertices.size());
}

// The control: a rod is no floor, however thin.
TEST(RigidParts, ARodIsNoFloor) {
  Piece rod = floor(1.0, 1.0, pelvis);
  for (Vector3d& p : rod.surface.vertices) p = p.cwiseProduct(Vector3d(60.0, 0.5, 0.5));
  EXPECT_EQ(count_rigid(scene_of(trunk_with({rod}))), 0u);
}

// A small part that was requested has the bones that it would have had if it had been found.
TEST(RigidParts, ASmallPartThatIsAskedForKeepsItsBones) {
  scene::Scene scene = scene_of(trunk_with({plate()}));
  const std::vector<build::Bone> found = bones_of(scene);
  scene.skeleton.rigid = {"Plate"};
  const std::vector<build::Bone> asked = bones_of(scene);
  ASSERT_EQ(asked.size(), found.size());
  for (std::size_t k = 0; k < asked.size(); ++k) EXPECT_EQ(asked[k].to, found[k].to);
}

// The trunk with hair of many strips, which are most of the skin. They are open and all face one way, so that
// no joint seems to move a limb.
rig::Character trunk_with_hair(bool is_soft, const std::vector<Piece>& more = {}) {
  rig::Character character = trunk_with(more);
  for (int k = 0; k < 300; ++k) {
    const double x = 0.013 * (k % 20) - 0.1, z = trunk_radius + 0.003 * (k / 20);
    add(character,
        {{{{x, 1.3, z}, {x + 0.05, 1.3, z}, {x, 0.5, z}, {x + 0.05, 0.5, z}}, {{0, 2, 1}, {1, 2, 3}}},
         Vector3d::Zero(),
         {{plate_joint, 1.0}},
         "Hair",
         "Hair"});
    for (std::size_t v = character.weights.size() - 4; is_soft && v + 2 < character.weights.size(); ++v) {
      character.joints[v] = {plate_joint, chest};
      character.weights[v] = {0.5, 0.5};
    }
  }
  return character;
}

// Rigid hair, soft hair, and soft hair on a floor: the bones are those of the body alone.
TEST(RigidParts, HairThatIsMostOfTheSkinHidesNoBone) {
  const std::vector<build::Bone> alone = bones_of(scene_of(trunk_with({})));
  ASSERT_FALSE(alone.empty());
  for (const rig::Character& character :
       {trunk_with_hair(false), trunk_with_hair(true), trunk_with_hair(true, {floor(20.0, 0.01, pelvis)})}) {
    const scene::Scene scene = scene_of(character);
    EXPECT_TRUE(build::choose_bones(character, scene.skeleton, 1.0, "").bones.empty()) << "the control";
    const std::vector<build::Bone> bones = bones_of(scene);
    ASSERT_EQ(bones.size(), alone.size());
    for (std::size_t k = 0; k < bones.size(); ++k) {
      EXPECT_EQ(bones[k].from, alone[k].from);
      EXPECT_EQ(bones[k].to, alone[k].to);
    }
  }
  EXPECT_EQ(count_rigid(scene_of(trunk_with_hair(false))), 300U * 4U);
  EXPECT_EQ(count_rigid(scene_of(trunk_with_hair(true))), 0U);
}

// Rigid shells that are most of the skin stay where they give a limb its bone: a body in armour under an open
// cape.
TEST(RigidParts, ArmourKeepsTheBonesThatItGives) {
  const auto shell = [](double y, std::uint32_t joint) {
    std::vector<Vector3d> line;
    for (int k = 0; k <= 4; ++k) line.emplace_back(0, y + 0.04 * k, 0);
    return Piece{tube(line, 0.2, 24), Vector3d::Zero(), {{joint, 1.0}}, "Armour", "Steel"};
  };
  rig::Character knight = trunk_with({});
  const std::vector<rig::Joint> skeleton = knight.skeleton;
  knight = {};
  knight.skeleton = skeleton;
  for (const double y : {0.0, 0.2, 0.4}) add(knight, shell(y, pelvis));
  for (const double y : {0.7, 0.9, 1.1}) add(knight, shell(y, chest));
  // An even strip would be rigid, too.
  add(knight,
      {{{{-0.1, 1.3, -0.3}, {0.1, 1.3, -0.3}, {-0.1, 0.5, -0.3}, {0.1, 0.5, -0.3}}, {{0, 1, 2}, {1, 3, 2}}},
       Vector3d::Zero(),
       {{chest, 1.0}},
       "Cape",
       "Cloth"});
  for (std::size_t v = knight.weights.size() - 4; v + 2 < knight.weights.size(); ++v) {
    knight.joints[v] = {pelvis, chest};
    knight.weights[v] = {0.5, 0.5};
  }
  const scene::Scene scene = scene_of(knight);
  EXPECT_EQ(count_rigid(scene), knight.surface.vertices.size() - 4);
  const std::vector<build::Bone> bones = bones_of(scene),
                                 of_all = build::choose_bones(knight, {}, 1.0, "").bones;
  ASSERT_FALSE(of_all.empty());
  ASSERT_EQ(bones.size(), of_all.size());
  for (std::size_t k = 0; k < bones.size(); ++k) EXPECT_EQ(bones[k].to, of_all[k].to);
}

// The controls: a block is no floor, and what is asked for is left out whatever its shape.
TEST(RigidParts, ABlockIsLeftOutOfTheChoiceOfBonesIfItIsAskedFor) {
  const std::vector<build::Bone> alone = bones_of(scene_of(trunk_with({})));
  scene::Scene scene = scene_of(trunk_with({floor(20.0, 5.0, chest)}));
  EXPECT_EQ(count_rigid(scene), 0u);
  const auto are_alone = [&](const std::vector<build::Bone>& bones) {
    return bones.size() == alone.size() &&
           std::equal(bones.begin(), bones.end(), alone.begin(),
                      [](const auto& a, const auto& b) { return a.from == b.from && a.to == b.to; });
  };
  EXPECT_FALSE(are_alone(bones_of(scene)));
  scene.skeleton.rigid = {"Floor"};
  EXPECT_TRUE(are_alone(bones_of(scene)));
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
}  // namespace fascicle::tests
