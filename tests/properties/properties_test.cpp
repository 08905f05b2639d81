// Properties over random bodies and parameters (rapidcheck): what is built and stepped stays finite, or is
// refused by a message that names what is wrong. RC_PARAMS="max_success=10000" makes a soak of it.
#include <cmath>
#include <set>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "cpu_reference/cpu_solver.h"
#include "host/bake/drive_source.h"
#include "host/build/build.h"
#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::tests {

namespace {

using Eigen::Vector3d;
using scene::Scene;

double number_in(double low, double high) {
  return low + (high - low) * (*rc::gen::inRange<int>(0, 1000001)) / 1e6;
}

// Small, large and edge values alike.
double fraction() {
  return *rc::gen::element(0.0, 1e-6, 0.3, 0.5, 0.999, 1.0, number_in(0.0, 1.0));
}

Vector3d direction() {
  return {number_in(-1, 1), number_in(-1, 1), number_in(-1, 1)};
}

Scene random_scene(scene::Geometry geometry) {
  Scene scene;
  scene.name = scene.source = "random";
  scene.geometry = std::move(geometry);
  scene.scale = *rc::gen::element(1.0, 1e-3, 1e3);
  const int layers = *rc::gen::inRange(1, 4);
  for (int k = 0; k < layers; ++k) {
    scene::Layer layer;
    layer.name = "layer" + std::to_string(k);
    layer.alpha = fraction();
    layer.beta = fraction();
    layer.damping = *rc::gen::element(0.0, 1.0, 13.4, 1e4);
    layer.density = *rc::gen::element(1.0, 1000.0, 2e4);
    if (const Vector3d d = direction(); d.norm() > 0.1 && *rc::gen::arbitrary<bool>())
      layer.fibre = d.normalized();
    layer.kinematic = *rc::gen::inRange(0, 6) == 0;
    if (k > 0)
      layer.where = {scene::HalfSpace{.axis = static_cast<scene::Axis>(*rc::gen::inRange(0, 3)),
                                      .below = *rc::gen::arbitrary<bool>(),
                                      .is_fraction = true,
                                      .value = number_in(0.0, 1.0)}};
    scene.layers.push_back(layer);
  }
  if (*rc::gen::arbitrary<bool>())
    scene.pins.push_back(
        {"pin",
         {scene::HalfSpace{.axis = scene::Axis::y, .below = true, .is_fraction = true, .value = 0.1}}});
  if (*rc::gen::arbitrary<bool>())
    scene.forces.push_back(
        {.name = "wind", .kind = scene::ForceKind::wind, .vector = direction() * number_in(0.0, 1e3)});
  scene.gravity = direction() * *rc::gen::element(0.0, 9.81, 1e3);
  scene.solver.rotation = *rc::gen::element<std::string>("qcp", "mueller2016");
  scene.solver.weights = *rc::gen::element<std::string>("symmetric", "kaneda2017");
  scene.solver.substeps = *rc::gen::element(1u, 2u, 8u);
  scene.fps = *rc::gen::element(1.0, 24.0, 60.0, 480.0);
  scene.end = 1.0;
  return scene;
}

// Builds and steps; true where it was built, false where it was refused by name. Anything else fails the
// property.
bool finite_or_refused(const Scene& scene) {
  build::Report report;
  model::Model model;
  try {
    model = build::build_model(scene, report);
  } catch (const scene::SceneError& error) {
    RC_ASSERT(std::string(error.what()).size() > 10u);
    return false;
  }
  model::check_model(model);
  bake::DriveSource drives(scene, model);
  const auto solver = cpu_reference::make_cpu_solver(
      model,
      {.rotation = scene.solver.rotation == "qcp" ? model::Rotation::qcp : model::Rotation::mueller2016}, 1);
  solver->load(drives.initial_state());
  for (std::uint64_t k = 1; k <= 10; ++k) {
    solver->submit(drives.drive(k), {.positions = true, .velocities = true, .surface = true});
    const model::Frame frame = solver->collect();
    for (const auto* values : {&frame.positions, &frame.velocities, &frame.surface})
      for (const float x : *values) RC_ASSERT(std::isfinite(x));
  }
  return true;
}

TEST(Properties, RandomBarsStayFinite) {
  int built = 0;
  EXPECT_TRUE(rc::check("a bar of any size, shape and material stays finite", [&] {
    scene::Bar bar;
    bar.size = {number_in(1e-3, 10.0), number_in(1e-3, 10.0), number_in(1e-3, 10.0)};
    for (auto& count : bar.vertices) count = static_cast<std::uint32_t>(*rc::gen::inRange(2, 7));
    bar.jitter = *rc::gen::element(0.0, 0.1, 0.3);
    bar.seed = *rc::gen::arbitrary<std::uint64_t>();
    built += finite_or_refused(random_scene(bar));
  }));
  EXPECT_GT(built, 50) << "most random bars are good ones";
}

// Points anywhere, also on top of each other and in one plane; tetrahedra of any four of them.
TEST(Properties, RandomTetrahedraStayFiniteOrAreRefused) {
  EXPECT_TRUE(rc::check("any tetrahedra stay finite or are refused", [] {
    scene::TetMesh mesh;
    const int points = *rc::gen::inRange(0, 12);
    for (int k = 0; k < points; ++k) {
      const double coordinate = *rc::gen::element(0.0, 1.0, number_in(-1, 1), 1e-30, 1e30, std::nan(""));
      mesh.vertices.emplace_back(coordinate, number_in(-1, 1), *rc::gen::element(0.0, number_in(-1, 1)));
    }
    const int tetrahedra = *rc::gen::inRange(0, 12);
    for (int k = 0; k < tetrahedra; ++k) {
      std::array<std::uint32_t, 4> corners{};
      for (auto& corner : corners) corner = static_cast<std::uint32_t>(*rc::gen::inRange(0, points + 1));
      mesh.tetrahedra.push_back(corners);
    }
    finite_or_refused(random_scene(mesh));
  }));
}

// Good meshes of random form: a tetrahedron grown by gluing tetrahedra to its faces.
TEST(Properties, GrownMeshesStayFinite) {
  int built = 0;
  EXPECT_TRUE(rc::check("a grown mesh stays finite", [&] {
    scene::TetMesh mesh;
    mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    mesh.tetrahedra = {{0, 1, 2, 3}};
    std::vector<std::array<std::uint32_t, 3>> faces{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
    const int growth = *rc::gen::inRange(0, 20);
    for (int k = 0; k < growth; ++k) {
      const auto at = static_cast<std::size_t>(*rc::gen::inRange<std::size_t>(0, faces.size()));
      const auto [a, b, c] = faces[at];
      const Vector3d normal =
          (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]);
      const Vector3d top = (mesh.vertices[a] + mesh.vertices[b] + mesh.vertices[c]) / 3 +
                           normal.normalized() * number_in(0.2, 1.0) + 0.1 * direction();
      const auto d = static_cast<std::uint32_t>(mesh.vertices.size());
      mesh.vertices.push_back(top);
      mesh.tetrahedra.push_back({a, b, c, d});
      faces.erase(faces.begin() + static_cast<std::ptrdiff_t>(at));
      faces.push_back({a, b, d});
      faces.push_back({b, c, d});
      faces.push_back({c, a, d});
    }
    built += finite_or_refused(random_scene(mesh));
  }));
  EXPECT_GT(built, 50);
}

}  // namespace

}  // namespace fascicle::tests
