// What tests of whole scenes begin with.
#pragma once

#include "host/build/build.h"
#include "host/build/stiffness.h"
#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::tests {

// The scene's model, with the mesher of this build; chooses the scene's substeps where it leaves them open.
inline model::Model built(scene::Scene& scene) {
  build::Report report;
  build::BuildOptions options;
  options.mesher = FASCICLE_MESHER;
  model::Model model = build::build_model(scene, report, options);
  build::choose_steps(scene, model, report);
  return model;
}

}  // namespace fascicle::tests
