// Layers and pins from shapes, masses from layers, probes, forces.
#include "host/build/layers.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include <gtest/gtest.h>

#include "host/build/bar.h"
#include "host/build/boundary.h"
#include "host/build/mass.h"
#include "host/model/model.h"
#include "tests/build/scenes.h"

namespace fascicle::tests {
namespace {

using model::Model;
using scene::Vector3d;

// The bar's grid spacing is 0.02 m, so an offset of 1e-6 m separates all vertices.
using Holds = std::function<bool(const Vector3d&)>;
void expect_shape(const scene::Shape& shape, const Holds& holds) {
  scene::Scene scene = bar_scene();
  scene.layers = {layer_named("rest"), layer_named("inside", {shape})};
  scene.bones = {{"bone", {0.1, 0.04, 0.04}, {0.3, 0.04, 0.04}}};
  const Model model = build_quietly(scene);
  std::size_t inside = 0;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    EXPECT_EQ(model.layer_of(i) == 1, holds(metres(model, i))) << metres(model, i).transpose();
    inside += model.layer_of(i);
  }
  EXPECT_GT(inside, 0u);
  EXPECT_LT(inside, model.vertex_count);
}

constexpr double off = 1e-6;

TEST(Layers, ABoxHoldsItsBounds) {
  expect_shape(scene::Box{{0.1, 0.02, 0.0}, {0.2, 0.06, 0.04}}, [](const Vector3d& p) {
    return p[0] > 0.1 - off && p[0] < 0.2 + off && p[1] > 0.02 - off && p[1] < 0.06 + off &&
           p[2] < 0.04 + off;
  });
}

TEST(Layers, ASphereHoldsItsBounds) {
  expect_shape(scene::Sphere{{0.2, 0.04, 0.04}, 0.04},
               [](const Vector3d& p) { return (p - Vector3d(0.2, 0.04, 0.04)).norm() < 0.04 + off; });
}

TEST(Layers, ACapsuleHoldsItsBounds) {
  expect_shape(scene::Capsule{{0.1, 0.04, 0.04}, {0.2, 0.04, 0.04}, 0.04}, [](const Vector3d& p) {
    const double along = std::clamp(p[0], 0.1, 0.2);
    return (p - Vector3d(along, 0.04, 0.04)).norm() < 0.04 + off;
  });
}

TEST(Layers, HalfSpacesHoldTheirBounds) {
  expect_shape(scene::HalfSpace{scene::Axis::x, true, false, 0.1},
               [](const Vector3d& p) { return p[0] < 0.1 + off; });
  expect_shape(scene::HalfSpace{scene::Axis::y, false, false, 0.06},
               [](const Vector3d& p) { return p[1] > 0.06 - off; });
  expect_shape(scene::HalfSpace{scene::Axis::z, true, true, 0.25},
               [](const Vector3d& p) { return p[2] < 0.02 + off; });
  expect_shape(scene::HalfSpace{scene::Axis::x, false, true, 1.0},
               [](const Vector3d& p) { return p[0] > 0.4 - off; });
}

TEST(Layers, ABoneDistanceHasTwoBounds) {
  expect_shape(scene::BoneDistance{0.02, 0.04}, [](const Vector3d& p) {
    const double d = (p - Vector3d(std::clamp(p[0], 0.1, 0.3), 0.04, 0.04)).norm();
    return d > 0.02 - off && d < 0.04 + off;
  });
}

// The depth on the bar in closed form: the nearest face of the box, and the bone of expect_shape.
double bar_depth(const Vector3d& p) {
  const double bone = (p - Vector3d(std::clamp(p[0], 0.1, 0.3), 0.04, 0.04)).norm();
  const double skin = std::min({p[0], 0.4 - p[0], p[1], 0.08 - p[1], p[2], 0.08 - p[2]});
  return bone > 0.0 ? bone / (bone + std::max(skin, 0.0)) : 0.0;
}

TEST(Layers, ADepthHasTwoBounds) {
  expect_shape(scene::Depth{0.2, 0.6}, [](const Vector3d& p) {
    const double depth = bar_depth(p);
    return depth > 0.2 - off && depth < 0.6 + off;
  });
}

// Three layers by volume share, in either order: each fills its share within 2 % of the whole, and no vertex
// of an inner layer is outside one of an outer layer.
TEST(Layers, VolumeSharesAreWhatWasAskedAndNest) {
  for (const bool by_distance : {false, true}) {
    scene::Scene scene = bar_scene();
    std::get<scene::Bar>(scene.geometry).vertices = {41, 9, 9};
    scene.bones = {{"bone", {0.1, 0.04, 0.04}, {0.3, 0.04, 0.04}}};
    scene.layers = {layer_named("fat"), layer_named("muscle", {scene::VolumeShare{0.0, 0.6, by_distance}}),
                    layer_named("bone", {scene::VolumeShare{0.0, 0.15, by_distance}})};
    build::Report report;
    const Model model = build::build_model(scene, report);
    const std::vector<double> asked{0.4, 0.45, 0.15};
    std::vector<double> least(3, 1.0), most(3, 0.0);
    for (std::size_t l = 0; l < 3; ++l) EXPECT_NEAR(report.layers[l].volume / report.volume, asked[l], 0.02);
    for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
      const Vector3d p = metres(model, i);
      const double outward =
          by_distance ? (p - Vector3d(std::clamp(p[0], 0.1, 0.3), 0.04, 0.04)).norm() : bar_depth(p);
      least[model.layer_of(i)] = std::min(least[model.layer_of(i)], outward);
      most[model.layer_of(i)] = std::max(most[model.layer_of(i)], outward);
    }
    EXPECT_LE(most[2], least[1] + off);
    EXPECT_LE(most[1], least[0] + off);
  }
}

TEST(Layers, AlphaRunsFromTheInnerToTheOuterSide) {
  scene::Scene scene = bar_scene();
  scene.bones = {{"bone", {0.1, 0.04, 0.04}, {0.3, 0.04, 0.04}}};
  scene.layers = {layer_named("fat"), layer_named("muscle", {scene::Depth{0.0, 0.6}})};
  scene.layers[1].alpha = 0.9;
  scene.layers[1].alpha_outer = 0.3;
  const Model model = build_quietly(scene);
  double outermost = 0.0;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    if (model.layer_of(i) == 1) outermost = std::max(outermost, bar_depth(metres(model, i)));
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    if (model.is_kinematic(i)) continue;
    const double expected =
        model.layer_of(i) == 0 ? 1.0 : 0.9 - 0.6 * bar_depth(metres(model, i)) / outermost;
    EXPECT_NEAR(double{model.alpha[i]}, expected, 1e-6);  // floats, and float positions
  }
  scene.bones.clear();
  scene.layers[1].where = {scene::HalfSpace{scene::Axis::x, true, true, 0.5}};
  expect_refusal([&] { build_quietly(scene); }, "layers.muscle.alpha_outer");
}

// A bar of flesh with two joints, one per half, and paint on its skin.
struct PaintedBar {
  build::Body body;
  std::vector<std::uint32_t> source_vertex;

  PaintedBar() {
    body.mesh = build::make_bar(scene::Bar{}, "test");
    const auto count = static_cast<std::uint32_t>(body.mesh.vertices.size());
    body.joints = {{"trunk", -1, 0, false}, {"hand", 0, 1, true}, {"finger", 1, 1, true}};
    body.joint_count = 3;
    body.bones = {{{0.0, 0.04, 0.04}, {0.3, 0.04, 0.04}, {0, -1, 1}},
                  {{0.3, 0.04, 0.04}, {0.4, 0.04, 0.04}, {1, 0, -1}}};
    body.skin.offset = {0};
    body.painted = {{"_LAYER", 1, {}}, {"COLOR_0", 4, {}}};
    body.skin_surface = {body.mesh.vertices, build::boundary_triangles(body.mesh, "test")};
    for (std::uint32_t i = 0; i < count; ++i) {
      const double x = body.mesh.vertices[i][0];
      body.skin.joint.push_back(x < 0.29 ? 0u : x < 0.35 ? 1u : 2u);
      body.skin.weight.push_back(1.0);
      body.skin.offset.push_back(i + 1);
      body.painted[0].values.push_back(x < 0.09 ? 2.0 : 0.0);
      for (const double value : {0.0, x / 0.4, 1.0, 1.0}) body.painted[1].values.push_back(value);
      source_vertex.push_back(i);
    }
  }

  build::Layering layer(const scene::Scene& scene) const {
    build::Report report;
    build::Measures measures(body);
    build::WhereTest test(measures);
    return build::assign_layers(scene, test, measures,
                                build::one_rings(body.mesh.vertices.size(), body.mesh.tetrahedra),
                                source_vertex, report);
  }
};

scene::Scene two_layers(const scene::Shape& shape) {
  scene::Scene scene = bar_scene();
  scene.pins.clear();
  scene.layers = {layer_named("rest"), layer_named("inside", {shape})};
  return scene;
}

TEST(Layers, AJointSetHoldsWhatItsJointsMove) {
  const PaintedBar bar;
  const build::Layering layering = bar.layer(two_layers(scene::JointSet{{"hand"}, 0.5}));
  for (std::size_t i = 0; i < layering.layer.size(); ++i)
    EXPECT_EQ(layering.layer[i], bar.body.mesh.vertices[i][0] > 0.29 ? 1u : 0u);
  expect_refusal(
      [&] {
        bar.layer(two_layers(scene::JointSet{{"nose"}, 0.5}));
      },
      "layers.inside.joints.names: no joint is called \"nose\"");
}

TEST(Layers, PaintIsTakenFromTheNearestSkin) {
  const PaintedBar bar;
  const build::Layering layering = bar.layer(two_layers(scene::Painted{"COLOR_0.g", 0.25, 0.75}));
  for (std::size_t i = 0; i < layering.layer.size(); ++i) {
    // Paint is linear along the bar, so on the long sides the nearest skin has the vertex's own value; near
    // the ends the nearest skin may be on an end face.
    const Vector3d& p = bar.body.mesh.vertices[i];
    if (p[0] < 0.045 || p[0] > 0.355) continue;
    EXPECT_EQ(layering.layer[i], p[0] > 0.099 && p[0] < 0.301 ? 1u : 0u) << p.transpose();
  }
  expect_refusal([&] { bar.layer(two_layers(scene::Painted{"COLOR_0", 0, 1})); }, "COLOR_0 of 4 numbers");
  expect_refusal([&] { bar.layer(two_layers(scene::Painted{"COLOR_1.r", 0, 1})); }, "layers.inside.painted");
}

TEST(Layers, PaintWinsOverOtherShapesWhateverTheOrder) {
  const PaintedBar bar;
  scene::Scene scene = two_layers(scene::Painted{"_LAYER", 1.5, 2.5});
  scene.layers.push_back(layer_named("all", {scene::Everywhere{}}));
  const build::Layering layering = bar.layer(scene);
  for (std::size_t i = 0; i < layering.layer.size(); ++i)
    EXPECT_EQ(layering.layer[i], bar.body.mesh.vertices[i][0] < 0.09 ? 1u : 2u);
}

// Layer numbers are names and must not be interpolated; shades are interpolated.
TEST(Layers, PaintedLayersAreNotMixed) {
  PaintedBar bar;
  for (double& value : bar.body.painted[0].values) value = value == 2.0 ? 3.0 : 0.0;
  for (scene::Vector3d& p : bar.body.mesh.vertices) p[0] += 0.004;  // not aligned with the skin's vertices
  build::Measures measures(bar.body);
  std::set<double> layers, shades;
  for (const double value : measures.painted("_LAYER", "key", "test")) layers.insert(value);
  for (const double value : measures.painted("COLOR_0.g", "key", "test")) shades.insert(value);
  EXPECT_EQ(layers, (std::set<double>{0.0, 3.0}));
  EXPECT_GT(shades.size(), 10u);
}

// A layer for which a paint file claims vertices is also the default for the rest of the body.
TEST(Layers, PaintOfAFileWinsAsPaintOfWhereDoes) {
  const PaintedBar bar;
  scene::Scene scene = two_layers(scene::Everywhere{});
  scene.layers[0].by_paint = {scene::Painted{"_LAYER", 1.5, 2.5}};
  const build::Layering painted = bar.layer(scene);
  scene.layers[1].where = {scene::HalfSpace{scene::Axis::x, false, true, 0.5}};
  const build::Layering rest = bar.layer(scene);
  for (std::size_t i = 0; i < painted.layer.size(); ++i) {
    const double x = bar.body.mesh.vertices[i][0];
    EXPECT_EQ(painted.layer[i], x < 0.09 ? 0u : 1u) << x;
    EXPECT_EQ(rest.layer[i], x < 0.199 ? 0u : 1u) << x;
  }
}

TEST(Layers, PaintedStiffnessMultipliesAlpha) {
  const PaintedBar bar;
  scene::Scene scene = two_layers(scene::Everywhere{});
  scene.layers[1].alpha = 0.5;
  const auto alphas = [&](const char* attribute) {
    scene.layers[1].alpha_attribute = attribute;
    return bar.layer(scene).alpha;
  };
  const std::vector<double> ramp = alphas("COLOR_0.g"), none = alphas("COLOR_0.r"), beyond = alphas("_LAYER");
  std::size_t painted_beyond_one = 0;
  for (std::size_t i = 0; i < ramp.size(); ++i) {
    const double x = bar.body.mesh.vertices[i][0];
    if (x > 0.045 && x < 0.355) {
      EXPECT_NEAR(ramp[i], 0.5 * x / 0.4, 1e-12);
    }
    EXPECT_EQ(none[i], 0.0) << "red is 0 everywhere";
    EXPECT_TRUE(beyond[i] == 0.0 || beyond[i] == 0.5) << "paint of 2 counts as 1, of 0 as 0: " << beyond[i];
    painted_beyond_one += beyond[i] > 0.0;
  }
  EXPECT_GT(painted_beyond_one, 5u);
}

// A bone runs along an edge of the bar, beside its vertices, so none is near enough: all are added.
TEST(Layers, WhatCompletesABoneIsInItsLayer) {
  PaintedBar bar;
  bar.body.bones = {{{0.0, 0.003, 0.0}, {0.4, 0.003, 0.0}, {0, -1, -1}}};
  bar.body.joints = {{"trunk", -1, 0, false}};
  bar.body.joint_count = 1;
  for (std::uint32_t& joint : bar.body.skin.joint) joint = 0;
  scene::Scene scene = two_layers(scene::BoneDistance{0.0, 0.001});
  scene.layers[1].kinematic = true;
  build::Report report;
  build::Measures measures(bar.body);
  build::WhereTest test(measures);
  const build::Layering layering = build::assign_layers(
      scene, test, measures, build::one_rings(bar.body.mesh.vertices.size(), bar.body.mesh.tetrahedra),
      bar.source_vertex, report);
  std::uint32_t bones = 0;
  for (std::size_t i = 0; i < layering.layer.size(); ++i) {
    const Vector3d& p = bar.body.mesh.vertices[i];
    const double from_edge = std::hypot(p[1], p[2]);
    if (from_edge > 0.05) continue;  // far from every bone
    EXPECT_EQ(layering.layer[i], from_edge < 1e-9 ? 1u : 0u) << p.transpose();
    bones += layering.layer[i];
  }
  EXPECT_EQ(layering.layer[0], 1u) << "the first vertex too";
  EXPECT_EQ(report.bone_vertices_added, bones);
}

TEST(Layers, BonesMayHaveExtentsOfTheirOwn) {
  const PaintedBar bar;
  const build::Layering layering = bar.layer(two_layers(scene::BoneDistance{0.0, 0.025, {{"trunk", 0.045}}}));
  for (std::size_t i = 0; i < layering.layer.size(); ++i) {
    const Vector3d& p = bar.body.mesh.vertices[i];
    const double distance = std::hypot(p[1] - 0.04, p[2] - 0.04);
    // The trunk's flesh counts the bones of the trunk and of the hand, its child. The hand's flesh follows
    // its joint and counts as bone.
    if (p[0] < 0.29)
      EXPECT_EQ(layering.layer[i], distance < 0.045 ? 1u : 0u) << p.transpose();
    else
      EXPECT_EQ(layering.layer[i], 1u);
  }
  expect_refusal(
      [&] {
        bar.layer(two_layers(scene::Depth{0.0, 0.5, {{"finger", 0.1}}}));
      },
      "no bone belongs to a joint called \"finger\"");
}

// Flesh that follows the skeleton counts as bone and is excluded from the volume that shares refer to.
TEST(Layers, SharesCountWhatIsFree) {
  const PaintedBar bar;
  const build::Layering layering = bar.layer(two_layers(scene::VolumeShare{0.0, 0.5, false}));
  double inside = 0.0, whole = 0.0;
  const std::vector<double> volume = build::lumped_volumes(bar.body.mesh);
  for (std::size_t i = 0; i < volume.size(); ++i) {
    if (bar.body.mesh.vertices[i][0] > 0.29) {
      EXPECT_EQ(layering.layer[i], 1u);
      continue;
    }
    whole += volume[i];
    inside += layering.layer[i] == 1 ? volume[i] : 0.0;
  }
  EXPECT_NEAR(inside / whole, 0.5, 0.02);
}

TEST(Layers, AnyShapeOfAListWillDo) {
  scene::Scene scene = bar_scene();
  scene.layers = {layer_named("rest"),
                  layer_named("ends", {scene::HalfSpace{scene::Axis::x, true, true, 0.0},
                                       scene::HalfSpace{scene::Axis::x, false, true, 1.0}})};
  build::Report report;
  build::build_model(scene, report);
  EXPECT_EQ(report.layers[1].vertices, 50u);
}

TEST(Layers, TheLastThatMatchesWins) {
  scene::Scene scene = bar_scene();
  const scene::HalfSpace low{scene::Axis::x, true, true, 0.5}, lower{scene::Axis::x, true, true, 0.25};
  scene.layers = {layer_named("low", {low}), layer_named("rest"), layer_named("lower", {lower})};
  build::Report report;
  build::build_model(scene, report);
  // 21 x 5 x 5 vertices: planes 0 to 5 are lower, 6 to 10 low. The layer without shapes takes the rest,
  // whatever its position in the list.
  EXPECT_EQ(report.layers[0].vertices, 5u * 25u);
  EXPECT_EQ(report.layers[1].vertices, 10u * 25u);
  EXPECT_EQ(report.layers[2].vertices, 6u * 25u);
  std::swap(scene.layers[0], scene.layers[2]);
  build::build_model(scene, report);
  EXPECT_EQ(report.layers[2].name, "low");
  EXPECT_EQ(report.layers[2].vertices, 11u * 25u);
  ASSERT_EQ(report.warnings.size(), 1u);
  EXPECT_EQ(report.warnings[0].text, "layers.lower: holds no vertex");
}

TEST(Layers, RefuseWhatTakesNoVertexOrLeavesSome) {
  const scene::Sphere nowhere{{9, 9, 9}, 0.1};
  scene::Scene scene = bar_scene();
  scene.layers[0].where = {scene::HalfSpace{scene::Axis::x, true, true, 0.5}};
  expect_refusal([&] { build_quietly(scene); }, "no layer covers 250 vertices");
  scene = bar_scene();
  scene.layers.clear();
  expect_refusal([&] { build_quietly(scene); }, "at least one");
  scene = bar_scene();
  scene.layers.push_back(layer_named("bone", {nowhere}));
  scene.layers[1].kinematic = true;
  expect_refusal([&] { build_quietly(scene); }, "layers.bone");
  scene = bar_scene();
  scene.pins[0].where = {nowhere};
  expect_refusal([&] { build_quietly(scene); }, "pins.end");
  scene = bar_scene();
  scene.probes = {{"tip", {nowhere}}};
  expect_refusal([&] { build_quietly(scene); }, "probe.tip");
  scene = bar_scene();
  scene.layers.push_back(layer_named("deep", {scene::BoneDistance{0.0, 0.1}}));
  expect_refusal([&] { build_quietly(scene); }, "add bones");
  scene = bar_scene();
  scene.layers.assign(257, layer_named("same"));
  expect_refusal([&] { build_quietly(scene); }, "256");
}

TEST(Layers, PinsAndKinematicLayersHoldVertices) {
  scene::Scene scene = bar_scene();
  scene.layers[0].alpha = 0.5;
  scene.layers.push_back(layer_named("bone", {scene::HalfSpace{scene::Axis::x, false, true, 1.0}}));
  scene.layers[1].kinematic = true;
  build::Report report;
  const Model model = build::build_model(scene, report);
  EXPECT_EQ(report.pinned_vertices, 50u);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    const double x = metres(model, i)[0];
    EXPECT_EQ(model.is_kinematic(i), x < 0.01 || x > 0.39);
    EXPECT_EQ(model.alpha[i], model.is_kinematic(i) ? 0.0f : 0.5f);
    EXPECT_GT(model.pull[i], 0.0f);
  }
}

TEST(Mass, IsDensityTimesVolume) {
  for (const double jitter : {0.0, 0.3}) {
    scene::Scene scene = bar_scene();
    std::get<scene::Bar>(scene.geometry).jitter = jitter;
    scene.layers[0].density = 930.0;
    build::Report report;
    const Model model = build::build_model(scene, report);
    const double volume = 0.4 * 0.08 * 0.08;
    double sum = 0.0;
    for (const double m : model.mass) sum += m;
    // 1920 volumes and 525 masses, each with a relative rounding error of 2^-53.
    EXPECT_NEAR(sum, 930.0 * volume, 930.0 * volume * 1e-12);
    EXPECT_NEAR(report.mass, sum, sum * 1e-12);
    EXPECT_NEAR(report.volume, volume, volume * 1e-12);
  }
}

TEST(Mass, FollowsTheLayersDensity) {
  scene::Scene scene = bar_scene();
  scene.layers = {layer_named("light"),
                  layer_named("heavy", {scene::HalfSpace{scene::Axis::x, true, true, 0.5}})};
  scene.layers[0].density = 900.0;
  scene.layers[1].density = 1800.0;
  build::Report report;
  const Model model = build::build_model(scene, report);
  const double volume = 0.4 * 0.08 * 0.08;
  // Planes 0 to 10 of 21: the first counts half and the other ten fully, so 10.5 of 20 cells.
  EXPECT_NEAR(report.layers[1].volume, volume * 10.5 / 20.0, volume * 1e-12);
  EXPECT_NEAR(report.layers[0].volume, volume * 9.5 / 20.0, volume * 1e-12);
  EXPECT_NEAR(report.layers[1].mass, 1800.0 * volume * 10.5 / 20.0, 1e-11);
}

TEST(Fibre, IsTheLayersUnitDirection) {
  scene::Scene scene = bar_scene();
  scene.layers = {layer_named("plain"),
                  layer_named("fibred", {scene::HalfSpace{scene::Axis::x, true, true, 0.5}})};
  scene.layers[0].beta = scene.layers[1].beta = 0.5;
  scene.layers[1].fibre = Vector3d(0, -3, 4);
  const Model model = build_quietly(scene);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    const bool fibred = model.layer_of(i) == 1;
    EXPECT_EQ(model.beta[i], fibred ? 0.5f : 0.0f);
    EXPECT_EQ(model.fibre[3 * i + 1], fibred ? -0.6f : 0.0f);
    EXPECT_EQ(model.fibre[3 * i + 2], fibred ? 0.8f : 0.0f);
  }
}

TEST(Probes, ListTheirVerticesAscending) {
  scene::Scene scene = bar_scene();
  scene.probes = {{"tip", {scene::HalfSpace{scene::Axis::x, false, true, 1.0}}}};
  const Model model = build_quietly(scene);
  ASSERT_EQ(model.probes.size(), 1u);
  EXPECT_EQ(model.probes[0].name, "tip");
  EXPECT_EQ(model.probes[0].vertices.size(), 25u);
  EXPECT_TRUE(std::is_sorted(model.probes[0].vertices.begin(), model.probes[0].vertices.end()));
  for (const std::uint32_t i : model.probes[0].vertices) EXPECT_NEAR(metres(model, i)[0], 0.4, 1e-7);
}

// The sum over vertices of mass times coefficient: the total push of a unit force.
double total_push(const Model& m, std::uint32_t force) {
  double sum = 0.0;
  for (std::uint32_t i = 0; i < m.vertex_count; ++i)
    for (std::uint32_t k = m.force_offset[i]; k < m.force_offset[i + 1]; ++k)
      if (m.force_index[k] == force) sum += m.mass[i] * double{m.force_coefficient[k]};
  return sum;
}

TEST(Forces, WindPushesWithTheAreaAndAPointForceWithItself) {
  scene::Scene scene = bar_scene();
  scene.pins.clear();
  scene.forces.push_back({"wind", scene::ForceKind::wind, {1, 0, 0}, {}});
  scene.forces.push_back(
      {"push", scene::ForceKind::point, {0, 1, 0}, {scene::HalfSpace{scene::Axis::x, false, true, 0.5}}});
  const Model model = build_quietly(scene);
  ASSERT_EQ(model.force_count, 2u);
  // Coefficients are rounded to float once.
  const double area = 2 * (0.4 * 0.08 * 2 + 0.08 * 0.08);
  EXPECT_NEAR(total_push(model, 0), area, area * 1e-7);
  EXPECT_NEAR(total_push(model, 1), 1.0, 1e-7);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    for (std::uint32_t k = model.force_offset[i]; k < model.force_offset[i + 1]; ++k)
      if (model.force_index[k] == 1) {
        EXPECT_GT(metres(model, i)[0], 0.19);
      }
  EXPECT_NO_THROW(model::check_model(model));
}

TEST(Forces, KinematicVerticesTakeNone) {
  scene::Scene scene = bar_scene();
  scene.forces.push_back({"wind", scene::ForceKind::wind, {1, 0, 0}, {}});
  scene.forces.push_back({"push", scene::ForceKind::point, {0, 1, 0}, {scene::Everywhere{}}});
  const Model model = build_quietly(scene);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    if (model.is_kinematic(i)) {
      EXPECT_EQ(model.force_offset[i], model.force_offset[i + 1]);
    }
  // The free vertices take all of the force.
  EXPECT_NEAR(total_push(model, 1), 1.0, 1e-7);
  scene.forces[1].where = scene.pins[0].where;
  expect_refusal([&] { build_quietly(scene); }, "force.push");
}

TEST(Forces, WithoutForcesThereAreNoArrays) {
  const Model model = build_quietly(bar_scene());
  EXPECT_EQ(model.force_count, 0u);
  EXPECT_TRUE(model.force_offset.empty());
}

}  // namespace
}  // namespace fascicle::tests
