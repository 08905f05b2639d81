// From a scene to a model for any solver.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/bake/bake.h"
#include "host/build/build.h"
#include "host/build/steps.h"
#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/pipeline/messages.h"
#include "host/scene/scene.h"

namespace fascicle::pipeline {

// The model with its build report and steps.
struct Built {
  model::Model model;
  build::Report report;
  build::Steps steps;
};

// The model has passed model::check_model. Throws
// scene::SceneError.
Built build_scene(const scene::Scene& scene, const build::BuildOptions& options, const Say& say);

// The same for a scene that is rebuilt repeatedly with other keys; nothing is cached outside `memory`.
Built build_scene_again(const scene::Scene& scene, const build::BuildOptions& options,
                        build::BuildMemory& memory);

model::SolverOptions solver_options(const scene::Scene& scene, const build::Steps& steps);

// The warning with the first of its vertices.
std::string warning_text(const build::Warning& warning);
// Reports the build's warnings, for callers whose result does not contain them.
void say_warnings(const build::Report& report, const Say& say);

// The openings of the skin, for the manifest.
std::vector<bake::OpenEndEntry> open_ends_of(const build::Report& report);

}  // namespace fascicle::pipeline
