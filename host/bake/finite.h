// Frames whose positions are no longer finite numbers.
#pragma once

#include <string>

#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/scene/scene.h"

namespace fascicle::bake {

bool all_finite(const model::Frame& frame);

// Of a frame that is not: which one, the first vertex, and what may help.
std::string not_finite_text(const scene::Scene& scene, const model::Model& model, const model::Frame& frame);

}  // namespace fascicle::bake
