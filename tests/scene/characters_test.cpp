// [character.NAME]: several characters are combined, with their own names and places, and invalid
// combinations are refused.
#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "host/made/made_character.h"
#include "host/rig/pose.h"
#include "host/scene/scene_json.h"
#include "host/scene/solids.h"
#include "tests/scene/scene_samples.h"
#include "tests/scene/scene_texts.h"
#include "tests/support/assets.h"

namespace fascicle::tests::characters_test {
namespace {

using namespace scene;

const std::string layers = "[layers.body]\nalpha = 0.5\n";
const std::string two =
    "[character.left]\nmade = \"arm\"\n"
    "[character.right]\nmade = \"arm\"\nat = [0.5, 1.0, 2.0]\nturn = [0, 90, 0]\nstart = 0.25\n" +
    layers;

const rig::Character& character(const Scene& scene) {
  return std::get<rig::Character>(scene.geometry);
}

TEST(Characters, AreJoinedUnderTheirNames) {
  const Scene scene = parse(two);
  const rig::Character alone = made::make_character("arm");
  const rig::Character& both = character(scene);
  const std::size_t joints = alone.skeleton.size(), vertices = alone.surface.vertices.size();
  ASSERT_EQ(both.skeleton.size(), 2 * (joints + 1));
  ASSERT_EQ(scene.characters.size(), 2u);
  EXPECT_EQ(scene.characters[1].first_joint, joints + 1);
  for (std::size_t k = 0; k < 2; ++k) {
    const std::string name = k == 0 ? "left" : "right";
    const std::size_t first = k * (joints + 1);
    EXPECT_EQ(both.skeleton[first].name, name);
    EXPECT_EQ(both.skeleton[first].parent, -1);
    for (std::size_t j = 0; j < joints; ++j) {
      const rig::Joint& joint = both.skeleton[first + 1 + j];
      EXPECT_EQ(joint.name, name + "/" + alone.skeleton[j].name);
      const std::int32_t parent = alone.skeleton[j].parent;
      EXPECT_EQ(joint.parent, static_cast<std::int32_t>(first) + (parent < 0 ? 0 : 1 + parent));
      EXPECT_EQ(character_of_joint(scene, first + 1 + j), k);
    }
    EXPECT_EQ(both.parts.at(k).object, name + "/arm");
    EXPECT_EQ(both.parts[k].first_vertex, k * vertices);
  }
  EXPECT_NE(both.parts[0].node, both.parts[1].node) << "otherwise formats would merge them into one object";
  ASSERT_EQ(both.clips.size(), 1u);
  EXPECT_EQ(clip_name(scene), "left/curl + right/curl");
  EXPECT_NEAR(scene.end, alone.clips[0].duration + 0.25, 1e-12) << "until the later one has ended";
}

// Products of about ten double matrices, with lengths up to 2 m.
constexpr double rounding = 1e-13;

TEST(Characters, StandAndMoveWhereTheSceneSays) {
  const Scene scene = parse(two);
  const rig::Character alone = made::make_character("arm");
  const rig::Character& both = character(scene);
  const Eigen::Matrix3d turn = turned_by({0, 90, 0});
  for (const double time : {0.0, 0.5, 1.25}) {
    const auto pose = rig::joint_transforms_at(both, &both.clips[0], time);
    for (std::size_t j = 0; j < alone.skeleton.size(); ++j) {
      const auto left = rig::joint_transforms_at(alone, &alone.clips[0], time);
      EXPECT_EQ(pose[1 + j], left[j]) << "the first is at the same place as alone";
      const auto late = rig::joint_transforms_at(alone, &alone.clips[0], time - 0.25);
      const Eigen::Matrix4d& right = pose[alone.skeleton.size() + 2 + j];
      EXPECT_LT((right.topLeftCorner<3, 3>() - turn * late[j].topLeftCorner<3, 3>()).norm(), rounding);
      EXPECT_LT(
          (right.topRightCorner<3, 1>() - (turn * late[j].topRightCorner<3, 1>() + Vector3d(0.5, 1.0, 2.0)))
              .norm(),
          rounding);
    }
  }
}

// In the bind pose, bodies are so far apart that the mesher does not join them and contact does not see them
// as close.
TEST(Characters, StandAWholeBodyApartInTheBindPose) {
  std::string text = layers;
  for (const char* name : {"a", "b", "c", "d", "e"})
    text += "[character." + std::string(name) + "]\nmade = \"bear\"\n";
  const Scene scene = parse(text);
  const rig::Character& all = character(scene);
  std::vector<Eigen::AlignedBox3d> boxes(5);
  for (std::size_t k = 0; k < 5; ++k)
    for (std::size_t v = 0; v < all.parts[k].vertex_count; ++v)
      boxes[k].extend(all.surface.vertices[all.parts[k].first_vertex + v]);
  for (std::size_t a = 0; a < 5; ++a)
    for (std::size_t b = 0; b < a; ++b)
      EXPECT_GE(boxes[a].exteriorDistance(boxes[b]), boxes[a].sizes().maxCoeff() * (1.0 - 1e-12)) << a << b;
}

TEST(Characters, ASingleOneIsLikeAScenesOnlyOne) {
  const Scene named = parse("[character.me]\nmade = \"arm\"\n" + layers);
  const Scene plain = parse("[character]\nmade = \"arm\"\n" + layers);
  EXPECT_EQ(character(named).surface.vertices, character(plain).surface.vertices);
  EXPECT_EQ(named.characters[0].bind_offset, Vector3d(0, 0, 0));
  EXPECT_EQ(named.end, plain.end);
  EXPECT_EQ(named.motion.rest, plain.motion.rest);
  EXPECT_EQ(named.motion.interpolation, plain.motion.interpolation);
}

TEST(Characters, GetLayersByTheLargest) {
  const Scene both = parse("[character.small]\nmade = \"arm\"\n[character.large]\nmade = \"bear\"\n");
  const Scene bear = parse("[character]\nmade = \"bear\"\n");
  ASSERT_EQ(both.layers.size(), bear.layers.size());
  for (std::size_t l = 0; l < both.layers.size(); ++l)
    EXPECT_EQ(both.layers[l].youngs_modulus, bear.layers[l].youngs_modulus);
  EXPECT_EQ(both.solver.substeps, bear.solver.substeps);
}

TEST(Characters, AreSetByTheirKeys) {
  const Scene moved = parse(two, {.set = {"character.right.at=[1, 2, 3]", "character.left.rigid=true"}});
  EXPECT_EQ(moved.characters[1].settings.at, Vector3d(1, 2, 3));
  EXPECT_TRUE(moved.characters[0].settings.rigid);
  const Scene other = parse(two, {.set = {"character.left.made=bear"}});
  EXPECT_EQ(other.characters[0].own.skeleton.size(), made::make_character("bear").skeleton.size());
  const auto starts = [](const std::string& message, const std::string& start) {
    EXPECT_EQ(message.substr(0, start.size()), start);
  };
  starts(refusal_of_text(two, {.set = {"character.rigth.at=[1, 2, 3]"}}),
         "--set character.rigth.at=[1, 2, 3]: character.rigth: unknown; did you mean right?");
  starts(refusal_of_text(two, {.set = {"character.right.att=[1, 2, 3]"}}),
         "--set character.right.att=[1, 2, 3]: character.right.att: unknown; did you mean at?");
  starts(
      refusal_of_text(two, {.clip = "curl"}),
      "--clip curl: the scene has characters by name; say whose clip it is: --set character.left.clip=curl");
}

TEST(Characters, AreInTheManifest) {
  const Json json = json_of(parse(two));
  ASSERT_EQ(json["characters"].size(), 2u);
  EXPECT_EQ(json["characters"][1]["name"], "right");
  EXPECT_EQ(json["characters"][1]["at"], Json({0.5, 1.0, 2.0}));
  EXPECT_EQ(json["characters"][1]["start"], 0.25);
  EXPECT_FALSE(json_of(parse("[character]\nmade = \"arm\"\n" + layers)).contains("characters"));
}

// Characters may have the names of keys.
TEST(Characters, MayBeNamedAsKeysAre) {
  const std::string text =
      "[character.resolution]\nmade = \"arm\"\n[character.file]\nmade = \"arm\"\n" + layers;
  const Scene scene = parse(text, {.resolution = "20mm"});
  EXPECT_EQ(scene.characters.size(), 2u) << "--resolution removes keys, but no character";
  EXPECT_EQ(scene.motion.interpolation, KeyInterpolation::as_authored) << "generated characters";
}

TEST(Characters, AreReadFromTheirFiles) {
  const std::filesystem::path man = asset("CesiumMan.glb");
  FASCICLE_NEEDS_ASSET(man);
  const Scene scene = parse(
      "[character.a]\nfile = \"CesiumMan.glb\"\n[character.b]\nfile = \"CesiumMan.glb\"\n"
      "at = [1, 0, 0]\n[character.c]\nmade = \"arm\"\n" +
          layers,
      {}, man.parent_path());
  ASSERT_EQ(scene.input_hashes.size(), 1u) << "a file used by two characters is one input";
  EXPECT_EQ(scene.input_hashes[0].first, man.string());
  EXPECT_EQ(scene.characters[1].file, man);
  EXPECT_TRUE(scene.characters[2].file.empty());
  EXPECT_EQ(scene.motion.interpolation, KeyInterpolation::smooth);
  const rig::Character& all = character(scene);
  EXPECT_EQ(all.parts[0].object.substr(0, 2), "a/");
  EXPECT_EQ(all.parts[1].object.substr(0, 2), "b/");
  for (const rig::Channel& channel : all.clips.at(0).channels) ASSERT_LT(channel.joint, all.skeleton.size());
}

TEST(Characters, RefuseWhatCannotBe) {
  EXPECT_EQ(refusal_of_text("[mesh]\nmade = \"bunny\"\n" + two),
            "sample.toml:3: character: conflicts with mesh; give one of bar, mesh, character");
  EXPECT_EQ(
      refusal_of_text("[character]\nclip = \"curl\"\n[character.left]\nmade = \"arm\"\n" + layers),
      "sample.toml:2: character.clip: conflicts with the tables of single characters, [character.NAME]; "
      "move it into each of them, or remove their names");
  EXPECT_EQ(refusal_of_text("[character.left]\nclip = \"curl\"\n" + layers),
            "sample.toml:1: character.left: lacks one of file, made");
  EXPECT_EQ(refusal_of_text("[character.left]\nmade = \"arm\"\nclip = \"jump\"\n" + layers).substr(0, 39),
            "sample.toml:3: character.left.clip: the");
  EXPECT_EQ(refusal_of_text(two + "[skeleton]\nkinematic = [\"left/hand\", \"forearm\"]\n"),
            "sample.toml:11: skeleton.kinematic: \"forearm\" does not name its character; names begin with a "
            "character's, "
            "as \"left/...\"; did you mean left/forearm?");
  EXPECT_EQ(refusal_of_text(two + "[collider.ball]\nshape = \"sphere\"\nradius = 0.1\njoint = \"hand\"\n"),
            "sample.toml:13: collider.ball.joint: there is no joint \"hand\"; did you mean left/hand?");
  EXPECT_EQ(
      refusal_of_text(two + "[collider.ball]\nshape = \"sphere\"\nradius = 0.1\njoint = \"left/hnd\"\n"),
      "sample.toml:13: collider.ball.joint: there is no joint \"left/hnd\"; did you mean left/hand?");
  EXPECT_EQ(refusal_of_text("[character.left]\nfile = \"none.glb\"\n" + layers),
            "sample.toml:2: character.left.file: none.glb does not exist");
  EXPECT_EQ(refusal_of_text("[character.left]\nfile = \"chair.obj\"\n" + layers),
            "sample.toml:2: character.left.file: chair.obj is a mesh without a skeleton; for a solid prop, "
            "set rigid = true in its [character.NAME]; for a body of flesh, use [mesh]");
  EXPECT_EQ(refusal_of_text("[character.left]\nmade = \"arm\"\nthickness = 0.01\n" + layers),
            "sample.toml:3: character.left.thickness: is only for a prop; set rigid = true, or leave it out");
  EXPECT_EQ(refusal_of_text("[character.left]\nfile = \"chair.obj\"\nrigid = true\n" + layers),
            "sample.toml:2: character.left.file: chair.obj does not exist");
}

// A solid attached to a joint is placed in the bind pose of that joint's character.
TEST(Characters, SolidsGoWithTheJointsOfEach) {
  const Scene scene = parse(two +
                            "[collider.ball]\nshape = \"sphere\"\nradius = 0.1\ncenter = [0.3, 0, 0]\n"
                            "joint = \"right/hand\"\n");
  EXPECT_EQ(bound_solid_of(scene, scene.colliders[0]).center,
            Vector3d(0.3, 0, 0) + scene.characters[1].bind_offset);
}

}  // namespace
}  // namespace fascicle::tests::characters_test
