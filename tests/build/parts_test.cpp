// Where shapes by material and object, joints with and without their descendants, and flesh of only some
// joints.
#include <filesystem>
#include <set>

#include <gtest/gtest.h>

#include "host/build/build.h"
#include "host/build/measures.h"
#include "host/build/where.h"
#include "host/scene/scene.h"
#include "host/scene/scene_file.h"

namespace fascicle::tests::parts_test {
namespace {

using build::Vector3d;

// Four vertices of a body about 1 m in size. The skin below y = 0.5 is a shoe, the rest a shirt.
build::Body two_parts() {
  build::Body body;
  body.mesh.vertices = {{0, 0.1, 0}, {0.5, 0.2, 0.1}, {0, 0.9, 0}, {0.5, 0.8, 0.1}};
  body.skin_surface.vertices = {{-1, 0, -1}, {2, 0, -1}, {-1, 0, 2}, {-1, 1, -1}, {2, 1, -1}, {-1, 1, 2}};
  body.skin_surface.triangles = {{0, 1, 2}, {3, 4, 5}};
  body.parts = {{"shoes", "leather", 3, 0, 3, 0, 1}, {"body", "cotton", 4, 3, 3, 1, 1}};
  return body;
}

std::vector<char> inside(const build::Body& body, const scene::Shape& shape) {
  build::Measures measures(body);
  build::WhereTest test(measures);
  return test.contains({shape}, "layers.fat.where", "test.toml");
}

TEST(Parts, AVertexIsOfThePartOfTheNearestSkin) {
  const build::Body body = two_parts();
  EXPECT_EQ(inside(body, scene::PartSet{{"leather"}, false}), (std::vector<char>{1, 1, 0, 0}));
  EXPECT_EQ(inside(body, scene::PartSet{{"body"}, true}), (std::vector<char>{0, 0, 1, 1}));
  EXPECT_EQ(inside(body, scene::PartSet{{"shoes", "body"}, true}), (std::vector<char>{1, 1, 1, 1}));
}

TEST(Parts, AnUnknownNameIsRefusedWithTheNearest) {
  const build::Body body = two_parts();
  try {
    inside(body, scene::PartSet{{"lether"}, false});
    FAIL() << "was accepted";
  } catch (const scene::SceneError& error) {
    EXPECT_NE(std::string(error.what())
                  .find("layers.fat.where.material.names: no material is called \"lether\"; did "
                        "you mean leather?"),
              std::string::npos)
        << error.what();
  }
}

TEST(Parts, JointsCountWithThoseBelowThemUnlessSaidOtherwise) {
  build::Body body = two_parts();
  body.joints = {{"thigh", -1, -1, false}, {"shin", 0, -1, false}};
  body.skin = {{0, 1, 2, 3, 4}, {0, 0, 1, 1}, {1.0, 1.0, 1.0, 1.0}};
  EXPECT_EQ(inside(body, scene::JointSet{{"thigh"}, 0.5, true}), (std::vector<char>{1, 1, 1, 1}));
  EXPECT_EQ(inside(body, scene::JointSet{{"thigh"}, 0.5, false}), (std::vector<char>{1, 1, 0, 0}));
}

// Free vertices of the built-in arm, grouped by the joint with the largest weight.
std::set<std::uint32_t> joints_with_free_flesh(const std::vector<std::string>& only) {
  scene::SceneOverrides overrides;
  overrides.only = only;
  const scene::Scene scene =
      scene::parse_scene({"test", "test.toml", "[character]\nmade = \"arm\"\n", {}}, overrides);
  build::Report report;
  build::BuildOptions options;
  options.mesher = std::filesystem::path(FASCICLE_BINARY_DIR) / "fascicle-mesher";
  const model::Model model = build::build_model(scene, report, options);
  std::set<std::uint32_t> joints;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    if (model.is_kinematic(i)) continue;
    std::uint32_t best = model.skin_offset[i];
    for (std::uint32_t k = best; k < model.skin_offset[i + 1]; ++k)
      if (model.skin_weight[k] > model.skin_weight[best]) best = k;
    joints.insert(model.skin_joint[best]);
  }
  return joints;
}

TEST(Parts, OnlyTheFleshOfTheJointsNamedIsFree) {
  const scene::Scene arm = scene::parse_scene({"test", "test.toml", "[character]\nmade = \"arm\"\n", {}}, {});
  const auto& skeleton = std::get<rig::Character>(arm.geometry).skeleton;
  std::uint32_t forearm = 0, upper_arm = 0;
  for (std::uint32_t j = 0; j < skeleton.size(); ++j) {
    if (skeleton[j].name == "forearm") forearm = j;
    if (skeleton[j].name == "upper_arm") upper_arm = j;
  }
  const std::set<std::uint32_t> all = joints_with_free_flesh({}), some = joints_with_free_flesh({"forearm"});
  EXPECT_TRUE(all.contains(upper_arm));
  EXPECT_TRUE(all.contains(forearm));
  EXPECT_FALSE(some.contains(upper_arm));
  EXPECT_TRUE(some.contains(forearm));
}

}  // namespace
}  // namespace fascicle::tests::parts_test
