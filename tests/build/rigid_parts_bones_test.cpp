// The bones of a body with rigid parts: floors, hair and what is asked for hide none, and armour keeps those
// that it gives.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "host/build/body.h"
#include "host/build/bone_choice.h"
#include "host/build/build.h"
#include "tests/build/made_surfaces.h"
#include "tests/build/rigid_trunk.h"
#include "tests/build/scenes.h"
#include "tests/build/surfaces.h"

namespace fascicle::tests::rigid_parts_test {
namespace {

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

}  // namespace
}  // namespace fascicle::tests::rigid_parts_test
