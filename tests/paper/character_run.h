// Runs every frame of a character's clip on the CPU, as `fascicle bake` does.
#pragma once

#include <functional>

#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/scene/scene.h"

namespace fascicle::tests {

// `file` is an asset. Calls `see` with each frame after the first, until it returns false; the frame has
// positions and skinned positions.
void run_character(
    const char* file, const scene::SceneOverrides& overrides,
    const std::function<bool(const model::Model&, const rig::Character&, const model::Frame&)>& see);

}  // namespace fascicle::tests
