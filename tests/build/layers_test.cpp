// Layers and pins by shapes, masses by layers, probes, forces.
#include "host/build/layers.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "host/build/bar.h"
#include "host/model/model.h"
#include "tests/build/scenes.h"

namespace fascicle::tests {
namespace {

using model::Model;
using scene::Vector3d;

scene::Layer layer_named(const std::string& name, const scene::Where& where = {}) {
  scene::Layer layer;
  layer.name = name;
  layer.where = where;
  return layer;
}

Vector3d metres(const Model& m, std::uint32_t i) {
  Vector3d p;
  for (std::size_t a = 0; a < 3; ++a)
    p[static_cast<Eigen::Index>(a)] = m.rest_origin[a] + m.unit * double{m.rest[3 * std::size_t{i} + a]};
  return p;
}

// The bar's grid is 0.02 m wide: a test point 1e-6 m off tells all vertices apart.
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
  // 21 x 5 x 5 vertices: planes 0 to 5 are lower, 6 to 10 low; the layer without shapes takes the rest
  // wherever it stands.
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
  expect_refusal([&] { build_quietly(scene); }, "no layer takes 250 vertices");
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
    // 1920 volumes and 525 masses, each rounded by 2^-53 of itself.
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
  // Planes 0 to 10 of 21: the first counts half, the other ten whole: 10.5 of 20 cells.
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

// Sum over vertices of mass times coefficient: what a unit force pushes with.
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
  // The free vertices take the whole force.
  EXPECT_NEAR(total_push(model, 1), 1.0, 1e-7);
  scene.forces[1].where = scene.pins[0].where;
  expect_refusal([&] { build_quietly(scene); }, "forces.push");
}

TEST(Forces, WithoutForcesThereAreNoArrays) {
  const Model model = build_quietly(bar_scene());
  EXPECT_EQ(model.force_count, 0u);
  EXPECT_TRUE(model.force_offset.empty());
}

}  // namespace
}  // namespace fascicle::tests
