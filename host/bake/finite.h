// Frames with positions that are not finite, or absurdly far away.
#pragma once

#include <string>

#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/scene/scene.h"

namespace fascicle::bake {

bool is_in_reach(const model::Frame& frame, double unit);

// For such a frame: its number, the first vertex, and a possible remedy.
std::string not_finite_text(const scene::Scene& scene, const model::Model& model, const model::Frame& frame);

}  // namespace fascicle::bake
