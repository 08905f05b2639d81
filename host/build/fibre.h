// The fibre direction of each region.
#pragma once

#include <cstdint>
#include <vector>

#include "host/scene/scene.h"

namespace fascicle::build {

// 3 floats a vertex: the unit direction of the vertex's layer, or 0 0 0 where the layer has none.
std::vector<float> fibre_directions(const std::vector<scene::Layer>& layers,
                                    const std::vector<std::uint32_t>& layer_of);

}  // namespace fascicle::build
