// The text of a scene file: every key reaches its place, and what does not fit together is refused; and
// overrides, which change it.
#include <array>
#include <cstdint>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "host/base/text.h"
#include "host/scene/scene_file.h"
#include "tests/gltf/gltf_builder.h"
#include "tests/scene/scene_samples.h"
#include "tests/scene/scene_texts.h"

namespace fascicle::tests {
namespace {

using namespace scene;

TEST(SceneText, GoesThroughTheWriterWithAllItsKeysAndInItsOrder) {
  const Scene scene = parse(bar_sample());
  // In file order, not alphabetical.
  ASSERT_EQ(scene.layers.size(), 3u);
  EXPECT_EQ(scene.layers[0].name, "skin");
  EXPECT_EQ(scene.layers[1].name, "fat");
  EXPECT_EQ(scene.layers[2].name, "bone");
  const Scene written =
      parse(bar_sample(), {.set = {"layers.fat.alpha=0.1", "layers.ash={where={below={value=0.1}}}"}});
  ASSERT_EQ(written.layers.size(), 4u);
  EXPECT_EQ(written.layers[1].alpha, 0.1);
  EXPECT_EQ(written.layers[3].name, "ash");
  EXPECT_EQ(describe(parse(written.text)), describe(written));
}

TEST(SceneText, ReadsEveryKeyIntoItsPlace) {
  const Scene s = parse(bar_sample());
  EXPECT_EQ(s.gravity, Vector3d(0.0, -1.5, 0.25));
  EXPECT_EQ(s.fps, 24.0);
  EXPECT_EQ(s.start, 0.5);
  EXPECT_EQ(s.end, 2.5);
  EXPECT_EQ(frame_count(s), 48u);
  const Bar bar = std::get<Bar>(s.geometry);
  EXPECT_EQ(bar.size, Vector3d(0.5, 0.25, 0.125));
  EXPECT_EQ(bar.vertices, (std::array<std::uint32_t, 3>{5, 4, 3}));
  EXPECT_EQ(bar.jitter, 0.125);
  EXPECT_EQ(bar.seed, 7u);
  ASSERT_EQ(s.bones.size(), 1u);
  EXPECT_EQ(s.bones[0].name, "thigh");
  EXPECT_EQ(s.bones[0].from, Vector3d(0.0, 0.1, 0.1));
  EXPECT_EQ(s.bones[0].to, Vector3d(0.4, 0.1, 0.1));
  const Layer& fat = layer(s, "fat");
  EXPECT_EQ(fat.alpha, 0.5);
  EXPECT_EQ(fat.beta, 0.75);
  EXPECT_EQ(fat.damping, 3.5);
  EXPECT_EQ(fat.density, 900.0);
  EXPECT_FALSE(fat.kinematic);
  // 0 3 4 has length 5; the divisions round once each.
  EXPECT_LT((*fat.fibre - Vector3d(0.0, 0.6, 0.8)).norm(), 1e-15);
  EXPECT_EQ(std::get<BoneDistance>(fat.where.at(0)).minimum, 0.01);
  EXPECT_EQ(std::get<BoneDistance>(fat.where.at(0)).maximum, 0.05);
  EXPECT_TRUE(layer(s, "skin").where.empty());
  EXPECT_FALSE(layer(s, "skin").fibre.has_value());
  EXPECT_TRUE(layer(s, "bone").kinematic);
  EXPECT_EQ(std::get<Capsule>(layer(s, "bone").where.at(0)).radius, 0.01);
  EXPECT_EQ(s.solver.integrator, Integrator::explicit_step);
  EXPECT_EQ(s.solver.rotation, Rotation::mueller2016);
  EXPECT_EQ(s.solver.weights, WeightForm::kaneda2017);
  EXPECT_EQ(s.solver.substeps, 5u);
  EXPECT_EQ(std::get<Box>(s.pins.at(0).where.at(0)).maximum, Vector3d(0.1, 0.1, 0.1));
  const auto below = std::get<HalfSpace>(s.pins.at(1).where.at(0));
  EXPECT_EQ(below.axis, Axis::x);
  EXPECT_TRUE(below.below);
  EXPECT_FALSE(below.is_fraction);
  EXPECT_EQ(below.value, 0.01);
  EXPECT_TRUE(std::holds_alternative<Everywhere>(s.probes.at(0).where.at(0)));
  EXPECT_EQ(std::get<Sphere>(s.probes.at(1).where.at(0)).center, Vector3d(0.2, 0.1, 0.0));
  const auto core = std::get<VolumeShare>(s.probes.at(2).where.at(0));
  EXPECT_EQ(std::tuple(core.minimum, core.maximum, core.by_distance), std::tuple(0.125, 0.5, true));
  const auto deep = std::get<Depth>(s.probes.at(3).where.at(0));
  EXPECT_EQ(std::pair(deep.minimum, deep.maximum), std::pair(0.125, 0.5));
  const auto above = std::get<HalfSpace>(s.probes.at(4).where.at(0));
  EXPECT_EQ(above.axis, Axis::z);
  EXPECT_FALSE(above.below);
  EXPECT_TRUE(above.is_fraction);
  EXPECT_EQ(above.value, 0.9);
  EXPECT_EQ(s.forces.at(0).kind, ForceKind::wind);
  EXPECT_EQ(s.forces.at(0).vector, Vector3d(0.0, 0.0, 10.0));
  EXPECT_EQ(s.forces.at(1).kind, ForceKind::point);
  EXPECT_EQ(s.forces.at(1).start, 0.25);
  EXPECT_EQ(s.forces.at(1).end, 0.75);
}

TEST(SceneText, TakesSeveralShapes) {
  const Scene scene = parse(
      "[bar]\n[layers.body]\n[pin.ends]\n"
      "where = [{ below = { axis = 'x', fraction = 0.1 } }, { above = { axis = 'x', fraction = 0.9 } }]\n");
  EXPECT_EQ(scene.pins.at(0).where.size(), 2u);
}

TEST(SceneText, RefusesWhatDoesNotFitTogether) {
  const std::string body = "[bar]\n[layers.body]\n";
  const std::vector<std::pair<std::string, std::string>> cases{
      {"[layers.body]\n", "sample.toml:1: scene: lacks one of bar, mesh, character"},
      {"[bar]\n", "sample.toml:1: layers: is missing"},
      {"[bar]\n[layers]\n", "sample.toml:2: layers: is empty"},
      {"[bar]\n[mesh]\nfile = 'a.off'\n[layers.body]\n", "sample.toml:2: mesh: conflicts with bar"},
      {"[mesh]\n[layers.body]\n", "sample.toml:1: mesh: lacks one of file, made"},
      {"[mesh]\nfile = 'nowhere.off'\n[layers.body]\n",
       "sample.toml:2: mesh.file: nowhere.off does not exist"},
      {"[mesh]\nfile = 'a.glb'\n[layers.body]\n", "sample.toml:2: mesh.file: a.glb is a character"},
      {"[mesh]\nfile = 'a.txt'\n[layers.body]\n", "sample.toml:2: mesh.file: a.txt is not a mesh file"},
      {"[character]\nfile = 'a.off'\n[layers.body]\n",
       "sample.toml:2: character.file: a.off is a mesh without a skeleton"},
      {"[character]\n[layers.body]\n", "sample.toml:1: character: lacks one of file, made"},
      {"[character]\nfile = 'a.glb'\nmade = 'arm'\n[layers.body]\n",
       "sample.toml:3: character.made: conflicts with file"},
      {"[character]\nmade = 'wolf'\n[layers.body]\n",
       "sample.toml:2: character.made: \"wolf\" is not one of bear, arm, arm-bent"},
      {body + "[layers.other]\n", "sample.toml:3: layers.other.where: is missing"},
      {body + "[layers.'a b']\n", "sample.toml:3: layers.a b: is not a name"},
      {body + "[layers]\nx = 1\n", "sample.toml:4: layers.x: takes a table"},
      {body + "[pin.a]\n", "sample.toml:3: pin.a.where: is missing"},
      {body + "[pin.a]\nwhere = []\n", "sample.toml:4: pin.a.where: is empty"},
      {body + "[pin.a]\nwhere = {}\n", "sample.toml:4: pin.a.where: lacks one of box"},
      {body + "[pin.a]\nwhere = { everywhere = false }\n", "sample.toml:4: pin.a.where.everywhere: is false"},
      {body + "[pin.a]\nwhere = { below = { value = 1, fraction = 1 } }\n",
       "sample.toml:4: pin.a.where.below.fraction: conflicts"},
      {body + "[pin.a]\nwhere = { bone_distance = { maximum = 1 } }\n",
       "sample.toml:4: pin.a.where.bone_distance: the scene has no bones"},
      {body + "[pin.a]\nwhere = { box = { minimum = [0, 1, 0], maximum = [1, 0, 1] } }\n",
       "sample.toml:4: pin.a.where.box: minimum"},
      {body + "[force.a]\nkind = 'wind'\nvector = [1, 0, 0]\nwhere = { everywhere = true }\n",
       "sample.toml:6: force.a.where: wind"},
      {body + "[force.a]\nkind = 'point'\nvector = [1, 0, 0]\n", "sample.toml:3: force.a.where: is missing"},
      {body + "[force.a]\nkind = 'wind'\nvector = [1, 0, 0]\nstart = 2\nend = 2\n",
       "sample.toml:3: force.a.end: is not after"},
      {body + "[bones.a]\nfrom = [1, 0, 0]\nto = [1, 0, 0]\n", "sample.toml:3: bones.a: from and to"},
      {body + "[scene]\nstart = 3\nend = 3\n", "sample.toml:5: scene.end: lies less than a frame"},
      {body + "[scene]\nend = 1e5\nfps = 1e5\n", "sample.toml:4: scene.end: asks for more than 10 million"},
      {"[bar]\nvertices = [4096, 4096, 4096]\n[layers.body]\n",
       "sample.toml:2: bar.vertices: asks for more than 100 million"},
      {body + "[collider.a]\nshape = 'sphere'\n", "sample.toml:3: collider.a.radius: is missing; a sphere"},
      {body + "[collider.a]\nshape = 'plane'\nradius = 1\n",
       "sample.toml:5: collider.a.radius: does not apply to a plane"},
      {body + "[collider.a]\nshape = 'plane'\nnormal = [0, 0, 0]\n",
       "sample.toml:5: collider.a.normal: has no length"},
      {body + "[collider.a]\nshape = 'capsule'\nradius = 1\nfrom = [1, 0, 0]\nto = [1, 0, 0]\n",
       "sample.toml:7: collider.a.to: is the same point as `from`"},
      {body + "[collider.a]\nshape = 'box'\nsize = [1, 1, 3]\nradius = 0.6\n",
       "sample.toml:6: collider.a.radius: is more than half"},
      {body + "[collider.a]\nshape = 'plane'\ntimes = [1, 1]\n",
       "sample.toml:5: collider.a.times: must ascend"},
      {body + "[collider.a]\nshape = 'plane'\ntimes = [1, 2]\n",
       "sample.toml:5: collider.a.times: has neither `offsets`"},
      {body + "[collider.a]\nshape = 'plane'\ntimes = [1, 2, 3]\noffsets = [[0, 0, 0], [1, 0, 0]]\n",
       "sample.toml:6: collider.a.offsets: has 2 entries and `times` has 3"},
      {body + "[collider.a]\nshape = 'plane'\njoint = 'knee'\n",
       "sample.toml:5: collider.a.joint: only a [character]"},
      {"[character]\nmade = 'arm'\n[layers.body]\n[collider.a]\nshape = 'plane'\njoint = 'forearn'\n",
       "sample.toml:6: collider.a.joint: there is no joint \"forearn\""},
      {body + "[layers.body]\n", "sample.toml:3: TOML: "},
      {body + "[layers.b\n", "sample.toml:3: TOML: "},
      {"\xff", "sample.toml:1: TOML: "}};
  for (const auto& [text, start] : cases)
    EXPECT_EQ(refusal_of_text(text).substr(0, start.size()), start) << text;
}

TEST(SceneText, AnEndThatIsNotGivenFollowsTheStart) {
  const Scene scene = parse("[scene]\nstart = 1.5\n[bar]\n[layers.body]\n");
  EXPECT_EQ(scene.end, 3.5);
  EXPECT_EQ(frame_count(scene), 120u);
}

TEST(Overrides, ReplaceWhatTheFileSaysAndTheLastOneWins) {
  const Scene scene = parse(
      bar_sample(), {.set = {"layers.fat.alpha=0.2", "scene.fps=50", "layers.fat.alpha=0.3", "scene.end=5"},
                     .fps = 12.0,
                     .start = 1.0});
  EXPECT_EQ(layer(scene, "fat").alpha, 0.3);
  EXPECT_EQ(scene.fps, 12.0);
  EXPECT_EQ(scene.start, 1.0);
  EXPECT_EQ(scene.end, 5.0);
  EXPECT_EQ(layer(scene, "fat").beta, 0.75);
}

TEST(Overrides, AddTablesThatTheFileLeftOut) {
  const Scene scene =
      parse("[bar]\n[layers.body]\n", {.set = {"solver.substeps=9", "probe.tip={where={everywhere=true}}"}});
  EXPECT_EQ(scene.solver.substeps, 9u);
  ASSERT_EQ(scene.probes.size(), 1u);
  EXPECT_EQ(scene.probes[0].name, "tip");
}

TEST(Overrides, OneFormOfAChoiceReplacesTheOther) {
  const Scene plane = parse(bar_sample(), {.set = {"pin.plane.where.below.fraction=0.5"}});
  EXPECT_TRUE(std::get<HalfSpace>(plane.pins.at(1).where.at(0)).is_fraction);
  EXPECT_EQ(std::get<HalfSpace>(plane.pins.at(1).where.at(0)).value, 0.5);
  const Scene ball = parse(bar_sample(), {.set = {"pin.plane.where.sphere={center=[0,0,0],radius=1}"}});
  ASSERT_EQ(ball.pins.at(1).where.size(), 1u);
  EXPECT_TRUE(std::holds_alternative<Sphere>(ball.pins.at(1).where[0]));
  const TemporaryFolder folder;
  write_tetrahedron_off(folder.path() / "a.off");
  const Scene mesh =
      parse(bar_sample(), {.set = {"mesh.file=" + (folder.path() / "a.off").string(), "mesh.scale=2"}});
  EXPECT_TRUE(std::holds_alternative<mesh::SurfaceMesh>(mesh.geometry));
  EXPECT_EQ(mesh.scale, 2.0);
}

TEST(Overrides, NameTheOptionWhenTheyAreWrong) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"layers.fat.alhpa=0.2", "layers.fat.alhpa: unknown; did you mean alpha?"},
      {"layers.fta.alpha=0.2", "layers.fta: unknown; did you mean fat?"},
      {"layres.fat.alpha=0.2", "layres: unknown; did you mean layers?"},
      {"layers.fat.alpha=2", "layers.fat.alpha: is 2; must be at most 1"},
      {"layers.fat.alpha=much", "layers.fat.alpha: takes a number, not text"},
      {"layers.fat.alpha.x=1", "layers.fat.alpha: has no keys inside"},
      {"layers.fat.alpha=1\nbeta=1", "layers.fat.alpha: the value is neither"},
      {"layers.fat=3", "layers.fat: takes a table"},
      {"solver.rotation=svd", "solver.rotation: \"svd\" is not one of qcp, mueller2016"},
      {"scene.fps=nan", "scene.fps: is not a finite number"},
      {"layers..alpha=1", "layers.: unknown"}};
  for (const auto& [set, message] : cases) {
    const std::string start = "--set " + base::shown_text(set) + ": " + message;
    EXPECT_EQ(refusal("bar-layers-iii", {.set = {set}}).substr(0, start.size()), start);
  }
  EXPECT_TRUE(refusal("bar-layers-iii", {.set = {"foo"}}).starts_with("--set foo: takes KEY.PATH=VALUE"));
  EXPECT_TRUE(refusal("bar-layers-iii", {.fps = 0.0})
                  .starts_with("--fps 0: scene.fps: is 0; must be at least 0.001"));
  EXPECT_TRUE(
      refusal("bar-layers-iii", {.end = -1.0}).starts_with("--end -1: scene.end: lies less than a frame"));
  EXPECT_TRUE(refusal("bar-layers-iii", {.start = 20.0}).starts_with("builtin:bar-layers-iii:"));
  EXPECT_TRUE(
      refusal("bar-layers-iii", {.clip = "walk"}).starts_with("--clip walk: the scene has no character"));
}

TEST(Overrides, RigidNamesReplaceTheSceneFiles) {
  // Names with characters that artists use: quotes, dots, spaces.
  const std::vector<std::string> names{"hand", "Plate.001 \"left\"", "x\\y"};
  EXPECT_EQ(load_scene("arm", {.rigid = names}).skeleton.rigid, names);
  EXPECT_TRUE(refusal("bar-layers-iii", {.rigid = {"hand"}}).starts_with("--rigid hand: the scene has no"));
}

}  // namespace
}  // namespace fascicle::tests
