// Models in the cache next to the filled bodies: a character that was built before is available at once,
// whichever of its clips is baked.
#pragma once

#include <optional>
#include <string>

#include "host/build/build.h"
#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::pipeline {

struct KeptModel {
  model::Model model;
  build::Report report;
};

// The key of the scene's model in the cache: changes with everything that determines the model and its
// report, including the program and the mesher. Empty if models are not cached: without a cache, or for a
// file that another program converted.
std::optional<std::string> kept_model_key(const scene::Scene& scene, const build::BuildOptions& options);

// Empty if there is none, or none that this program can use.
std::optional<KeptModel> find_kept_model(const std::string& key, const build::BuildOptions& options);

void keep_model(const std::string& key, const model::Model& model, const build::Report& report,
                const build::BuildOptions& options);

}  // namespace fascicle::pipeline
