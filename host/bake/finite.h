// Frames with positions that are not finite.
#pragma once

#include <string>

#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/scene/scene.h"

namespace fascicle::bake {

bool all_finite(const model::Frame& frame);

// For such a frame: its number, the first vertex, and a possible remedy.
std::string not_finite_text(const scene::Scene& scene, const model::Model& model, const model::Frame& frame);

}  // namespace fascicle::bake
