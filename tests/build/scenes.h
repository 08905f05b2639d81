// Scenes and checks shared by the build tests.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include <gtest/gtest.h>

#include "host/build/build.h"
#include "host/scene/scene.h"

namespace fascicle::tests {

// A bar of 21 x 5 x 5 vertices, one layer with a skew fibre, its low x end pinned.
inline scene::Scene bar_scene() {
  scene::Scene scene;
  scene.name = "bar";
  scene.source = "test";
  scene.geometry = scene::Bar{};
  scene::Layer body;
  body.name = "body";
  body.beta = 0.6;
  body.fibre = scene::Vector3d(1, 2, 3).normalized();
  scene.layers = {body};
  scene.pins = {{"end", {scene::HalfSpace{scene::Axis::x, true, true, 0.0}}}};
  return scene;
}

inline scene::Layer layer_named(const std::string& name, const scene::Where& where = {}) {
  scene::Layer layer;
  layer.name = name;
  layer.where = where;
  return layer;
}

// The rest position of vertex `i`, in metres.
inline scene::Vector3d metres(const model::Model& model, std::uint32_t i) {
  scene::Vector3d p;
  for (std::size_t a = 0; a < 3; ++a)
    p[static_cast<Eigen::Index>(a)] =
        model.rest_origin[a] + model.unit * double{model.rest[3 * std::size_t{i} + a]};
  return p;
}

inline build::BuildOptions with_mesher() {
  build::BuildOptions options;
  options.mesher = std::filesystem::path(FASCICLE_BINARY_DIR) / "fascicle-mesher";
  return options;
}

inline model::Model build_with(const scene::Scene& scene, const build::BuildOptions& options) {
  build::Report report;
  return build::build_model(scene, report, options);
}

inline model::Model build_quietly(const scene::Scene& scene) {
  return build_with(scene, {});
}

// Expects a SceneError whose message contains `part`.
inline void expect_refusal(const std::function<void()>& action, const std::string& part) {
  try {
    action();
    ADD_FAILURE() << "nothing was thrown; expected \"" << part << "\"";
  } catch (const scene::SceneError& error) {
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

// An irregular bar of implicit flesh that hangs from its pins.
inline scene::Scene elastic_scene(double E) {
  scene::Scene scene = bar_scene();
  scene.geometry = scene::Bar{.vertices = {9, 4, 4}, .jitter = 0.2};
  scene.solver.integrator = scene::Integrator::implicit_step;
  scene.layers[0].youngs_modulus = E;
  return scene;
}

}  // namespace fascicle::tests
