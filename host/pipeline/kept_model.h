// Models beside the filled bodies in the cache: a character that was built before is there at once, whichever
// of its clips is baked.
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

// The name of the scene's model in the cache: changes with everything that the model and its report follow
// from, the program and the mesher among them. Nothing where models are not kept: without a cache, or of a
// file that another program converted.
std::optional<std::string> kept_model_key(const scene::Scene& scene, const build::BuildOptions& options);

// Nothing where there is none, or none that this program can rely on.
std::optional<KeptModel> find_kept_model(const std::string& key, const build::BuildOptions& options);

void keep_model(const std::string& key, const model::Model& model, const build::Report& report,
                const build::BuildOptions& options);

}  // namespace fascicle::pipeline
