// Builds a scene for tests of whole scenes.
#pragma once

#include <cstdint>
#include <utility>

#include "host/build/build.h"
#include "host/build/steps.h"
#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::tests {

struct BuiltScene {
  model::Model model;
  std::uint32_t substeps = 0;  // per frame
  model::SolverOptions options = {};
};

// Uses the mesher of this build.
inline BuiltScene built(const scene::Scene& scene) {
  build::Report report;
  build::BuildOptions options;
  options.mesher = FASCICLE_MESHER;
  model::Model model = build::build_model(scene, report, options);
  const build::Steps steps = build::choose_steps(scene, model, report);
  const model::SolverOptions stepping{.integrator = scene.solver.integrator,
                                      .rotation = scene.solver.rotation,
                                      .iterations = steps.iterations,
                                      .viscosity = scene.solver.viscosity};
  return {std::move(model), steps.substeps, stepping};
}

}  // namespace fascicle::tests
