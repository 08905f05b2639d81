// Keys of the scene file that depend on others: those that need a skeleton, a joint or another key, those
// that exclude each other, and those that follow from others.
#include <cstddef>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "host/scene/scene.h"
#include "tests/scene/scene_keys.h"
#include "tests/scene/scene_samples.h"
#include "tests/support/assets.h"

namespace fascicle::tests {
namespace {

using scene::Scene;

// Keys that require other keys, and names that need quotes.
TEST_F(SceneKeys, BonesJointsAndPaintNeedWhatHasThem) {
  const std::vector<std::pair<std::string, std::string>> refused{
      {"layers.fat.where.depth.maximum=0.5\nlayers.fat.where.depth.minimum=0.6", "neither TOML"},
      {"layers.fat.where={depth={minimum=0.6,maximum=0.5}}", "minimum is above maximum"},
      {"layers.fat.where={volume_share={minimum=0.6,maximum=0.5}}", "minimum is above maximum"},
      {"layers.fat.where={joints={names=[\"hand\"]}}", "only a [character]"},
      {"layers.fat.where={painted={attribute=\"_LAYER\",minimum=0,maximum=1}}", "only a [character]"},
      {"layers.fat.where={depth={maximum=0.5,per_bone={hand=0.3}}}", "only a [character]"},
      {"layers.fat.alpha_attribute=_STIFFNESS", "only a [character]"},
      {"contact.attribute=_CONTACT", "contact.attribute: only a [character]"},
      {"layers.fat.fibre_field=true", "conflicts with fibre_field"},
      {"fibres.biceps.points=[[0,0,0],[0,0,0]]", "the same point twice"},
      {"fibres.biceps.points=[[0,0,0],[0,2e6,0]]", "must be at most"},
      {"skeleton.connect=false", "only a [character]"}};
  for (const auto& [set, reason] : refused)
    EXPECT_NE(refusal(bar_sample(), {.set = {set}}).find(reason), std::string::npos)
        << refusal(bar_sample(), {.set = {set}});
  EXPECT_NE(refusal(mesh_sample(), {.set = {"layers.body.where={depth={maximum=0.5}}"}}).find("no bones"),
            std::string::npos);
}

TEST_F(SceneKeys, IgnoredContactIsListsOfOneOrTwoNames) {
  const std::vector<std::pair<std::string, std::string>> refused{
      {"[]", "contact.ignore: is empty; leave it out, or name something"},
      {"[\"tail\"]", "contact.ignore[0]: takes an array of one or two names, [\"a\", \"b\"], not text"},
      {"\"tail\"", "contact.ignore: takes an array of arrays of one or two texts in quotes, not text"},
      {"[[\"fat\"], []]",
       "contact.ignore[1]: has 0 names; give two that have no contact with each other, or one"},
      {"[[\"a\", \"b\", \"c\"]]", "contact.ignore[0]: has 3 names"},
      {"[[\"fat\", 2]]", "contact.ignore[0][1]: takes text in quotes, not a whole number"}};
  for (const auto& [value, reason] : refused)
    EXPECT_NE(refusal(bar_sample(), {.set = {"contact.ignore=" + value}}).find(reason), std::string::npos)
        << refusal(bar_sample(), {.set = {"contact.ignore=" + value}});
}

TEST_F(SceneKeys, MusclesNeedAJointOrABone) {
  const std::vector<std::pair<std::string, std::string>> refused{
      {"", "muscle.m.joint: is missing; name the joint"},
      {"bone = \"hand\"\naxis = \"flexion\"", "muscle.m.axis: applies to a muscle that follows a joint"},
      {"joint = \"hand\"\nlayer = \"bodi\"",
       "muscle.m.layer: there is no layer \"bodi\"; did you mean body?"},
      {"joint = \"foerarm\"", "sample.toml:4: muscle.m.joint: no joint is called \"foerarm\""},
      {"joint = \"hand\"\ncontraction_channel = \"hand.bend\"",
       "sample.toml:4: muscle.m.contraction_channel: \"hand.bend\" is not a channel"},
      {"joint = \"hand\"\nactivation = \"sine\"\ncurve = [[0, 0]]",
       "muscle.m.curve: conflicts with activation"},
      {"joint = \"hand\"\ncurve = [[1, 0], [1, 0]]", "muscle.m.curve[1]: does not come after"},
      {"joint = \"hand\"\ncurve = [[1, 0, 2]]", "muscle.m.curve[0]: has 3 entries"},
      {"joint = \"hand\"\ncurve = []", "muscle.m.curve: is empty"},
      {"joint = \"hand\"\ncontraction = [[0, 1]]\ncontraction_channel = \"a.scale.x\"",
       "muscle.m.contraction_channel: conflicts with contraction"}};
  for (const auto& [keys, reason] : refused)
    EXPECT_NE(refusal("[character]\nmade = \"arm\"\n[layers.body]\n[muscle.m]\n" + keys + "\n").find(reason),
              std::string::npos)
        << keys << ": " << refusal("[character]\nmade = \"arm\"\n[layers.body]\n[muscle.m]\n" + keys + "\n");
  EXPECT_NE(refusal("[bar]\n[layers.body]\n[muscle.m]\njoint = \"a\"\n").find("only a [character]"),
            std::string::npos);
}

TEST_F(SceneKeys, ACharacterNeedsNoLayers) {
  const Scene scene =
      parse("[character]\nmade = \"arm\"\n[muscle.m]\njoint = \"forearm\"\nlayer = \"muscle\"\n");
  ASSERT_EQ(scene.layers.size(), 3u);
  EXPECT_EQ(scene.layers[1].name, "muscle");
  EXPECT_EQ(scene.solver.integrator, scene::Integrator::implicit_step);
  EXPECT_EQ(describe(parse(scene.text)), describe(scene)) << "the text names what was added";
  EXPECT_NE(refusal("[bar]\n").find("layers: is missing"), std::string::npos);
}

// Physical units, unless the explicit integrator or an alpha is requested, by the scene or an override.
TEST_F(SceneKeys, ACharacterWithoutLayersGetsThemForItsIntegrator) {
  const std::string plain = "[character]\nmade = \"arm\"\n";
  for (const Scene& scene :
       {parse(plain), parse(plain + "[solver]\nintegrator = \"implicit\"\n"),
        parse(plain, {.set = {"solver.integrator=implicit"}}),
        parse(plain + "[solver]\nintegrator = \"explicit\"\n", {.set = {"solver.integrator=implicit"}})}) {
    ASSERT_EQ(scene.layers.size(), 3u);
    EXPECT_EQ(scene.solver.integrator, scene::Integrator::implicit_step);
    EXPECT_TRUE(scene.solver.auto_substeps);
    EXPECT_FALSE(scene.solver.iterations);
    // The paper's ratio of 0.3 between fat and muscle.
    EXPECT_NEAR(*scene.layers[0].youngs_modulus, 0.3 * *scene.layers[1].youngs_modulus,
                0.01 * *scene.layers[1].youngs_modulus);
  }
  for (const Scene& scene :
       {parse(plain + "[solver]\nintegrator = \"explicit\"\n"),
        parse(plain, {.set = {"solver.integrator=implicit", "solver.integrator=explicit"}}),
        parse(plain, {.set = {"solver.weights=kaneda2017"}}),
        parse(plain + "[solver]\nweights = \"kaneda2017\"\n")}) {
    EXPECT_EQ(scene.solver.integrator, scene::Integrator::explicit_step);
    EXPECT_TRUE(scene.solver.auto_substeps);
    EXPECT_EQ(scene.layers[1].alpha, 1.0);
  }
  const std::string set = "layers.fat.alpha=0.125";
  EXPECT_EQ(parse(plain, {.set = {"solver.integrator=explicit", set}}).layers[0].alpha, 0.125);
  EXPECT_EQ(
      refusal(plain, {.set = {set}}).find("--set " + set + ": layers.fat.alpha: takes solver.integrator"),
      0u);
}

// A bear is larger than an arm, and its clips last as long: waves must cross it in the same time.
TEST_F(SceneKeys, FleshOfACharacterWithoutLayersGoesByItsSize) {
  const Scene arm = parse("[character]\nmade = \"arm\"\n"), bear = parse("[character]\nmade = \"bear\"\n");
  const auto extent = [](const Scene& of) {
    Eigen::AlignedBox3d box;
    for (const scene::Vector3d& p : std::get<rig::Character>(of.geometry).surface.vertices) box.extend(p);
    return box.sizes().maxCoeff();
  };
  const double larger = extent(bear) / extent(arm);
  ASSERT_GT(larger, 1.5);
  for (const std::size_t l : {0u, 1u}) {
    // The values are written with three digits.
    EXPECT_NEAR(*bear.layers[l].youngs_modulus / *arm.layers[l].youngs_modulus, larger * larger,
                0.01 * larger * larger);
    EXPECT_EQ(bear.layers[l].damping, arm.layers[l].damping);
  }
}

// A scene without an integrator gets the one that fits the stiffness keys of its layers.
TEST_F(SceneKeys, LayersChooseTheIntegrator) {
  const auto integrator_of = [this](const std::string& body, const std::vector<std::string>& set) {
    return parse(
               "[bar]\n[layers.bone]\nkinematic = true\nwhere = { below = { axis = \"y\", fraction = 0.1 } "
               "}\n"
               "[layers.body]\n" +
                   body,
               {.set = set})
        .solver.integrator;
  };
  EXPECT_EQ(integrator_of("", {}), scene::Integrator::explicit_step);
  EXPECT_EQ(integrator_of("alpha = 0.5\n", {}), scene::Integrator::explicit_step);
  for (const char* stated : {"youngs_modulus = 1e4\n", "frequency = 5.0\n", "material = \"fat\"\n"})
    EXPECT_EQ(integrator_of(stated, {}), scene::Integrator::implicit_step) << stated;
  EXPECT_EQ(integrator_of("alpha = 0.5\n", {"layers.body.frequency=5"}), scene::Integrator::implicit_step);
  EXPECT_EQ(integrator_of("frequency = 5.0\n", {"layers.body.alpha=0.5"}), scene::Integrator::explicit_step);
}

// A layer gives its stiffness by exactly one key, which its integrator must accept.
TEST_F(SceneKeys, StiffnessIsStatedOnceAndByItsIntegrator) {
  const auto with = [](const std::string& line) {
    return implicit_sample() + "\n[layers.more]\n" + line + "\n";
  };
  const std::string where = "where = { everywhere = true }\n";
  EXPECT_NE(refusal(with("youngs_modulus = 1.0\nfrequency = 2.0\n" + where))
                .find("frequency: conflicts with youngs_modulus"),
            std::string::npos);
  EXPECT_NE(refusal(with("material = \"fat\"\nfrequency = 2.0\n" + where)).find("conflicts with"),
            std::string::npos);
  EXPECT_NE(refusal(with("frequency = 2.0\ndamping = 1.0\ndamping_ratio = 0.5\n" + where))
                .find("conflicts with damping"),
            std::string::npos);
  EXPECT_NE(refusal(with(where)).find("layers.more: has no stiffness"), std::string::npos);
  EXPECT_NE(refusal(with("alpha = 0.5\n" + where))
                .find("layers.more.alpha: takes solver.integrator = \"explicit\""),
            std::string::npos);
  EXPECT_EQ(refusal(with("kinematic = true\n" + where)), "no error");
  EXPECT_EQ(refusal(with("frequency = 2.0\nsliding = true\n" + where)), "no error");
  EXPECT_EQ(refusal(with("frequency = 2.0\nleast_volume = 0.3\n" + where)), "no error");
  const std::string slides = refusal(with("kinematic = true\nsliding = true\n" + where));
  EXPECT_NE(slides.find("sliding: is for flesh that moves by itself"), std::string::npos) << slides;
  EXPECT_NE(refusal(with("kinematic = true\nfrequency = 2.0\n" + where)).find("a kinematic layer does not"),
            std::string::npos);
  const std::vector<std::pair<std::string, std::string>> refused{
      {"layers.fat.youngs_modulus=1e4", "layers.fat.youngs_modulus: takes solver.integrator = \"implicit\""},
      {"layers.fat.least_volume=0.3", "layers.fat.least_volume: takes solver.integrator = \"implicit\""},
      {"layers.fat.damping_ratio=0.5", "layers.fat.damping_ratio: takes solver.integrator = \"implicit\""},
      {"solver.substeps=many", "is not one of auto"},
      {"solver.iterations=5", "solver.iterations: takes"},
      {"solver.quality=final", "solver.quality: takes"},
      {"solver.viscosity=0.001", "solver.viscosity: takes"}};
  EXPECT_NE(refusal(implicit_sample(), {.set = {"solver.substeps=auto", "solver.iterations=1"}})
                .find("solver.iterations: is 1, which resolves no stiffness"),
            std::string::npos);
  EXPECT_NE(
      refusal(implicit_sample(), {.set = {"solver.substeps=4"}}).find("solver.quality: applies only with"),
      std::string::npos);
  EXPECT_EQ(refusal(implicit_sample(), {.set = {"solver.substeps=4"}, .quality = "final"}), "no error");
  for (const auto& [set, reason] : refused)
    EXPECT_NE(refusal(bar_sample(), {.set = {set}}).find(reason), std::string::npos)
        << refusal(bar_sample(), {.set = {set}});
  // --set of one key replaces the other.
  const Scene in_hertz =
      parse(implicit_sample(), {.set = {"layers.fat.frequency=5", "layers.fat.damping=2"}});
  EXPECT_FALSE(in_hertz.layers[0].youngs_modulus);
  EXPECT_EQ(in_hertz.layers[0].frequency, 5.0);
  EXPECT_FALSE(in_hertz.layers[0].damping_ratio);
  EXPECT_EQ(in_hertz.layers[0].damping, 2.0);
  const Scene by_name = parse(implicit_sample(), {.set = {"layers.fat.material=relaxed-muscle"}});
  EXPECT_EQ(by_name.layers[0].youngs_modulus, 7000.0);
  EXPECT_EQ(by_name.layers[0].density, 1040.0);
}

TEST_F(SceneKeys, NamesThatNeedQuotesAreWrittenBack) {
  FASCICLE_NEEDS_ASSET(character_);
  const Scene once = parse(character_sample(), {.set = {"character.resolution=0.1"}});
  EXPECT_NE(once.text.find("leg joint.R"), std::string::npos);
  EXPECT_EQ(describe(parse(once.text)), describe(once));
}

}  // namespace
}  // namespace fascicle::tests
