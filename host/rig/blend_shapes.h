// Blend shapes (glTF's morph targets) and their weights over time.
#pragma once

#include <cstdint>
#include <vector>

#include "host/rig/character.h"

namespace fascicle::rig {

// How one shape at weight 1 moves the vertices of a part, in the part's own space, before skinning.
struct BlendShape {
  std::vector<std::uint32_t> vertex;  // the vertices it moves, ascending
  std::vector<Vector3d> move;         // displacement of each
};

// The weights at `time` (s), one per shape, held constant before the first and after the last key.
std::vector<double> weights_at(const WeightChannel& channel, double time);

}  // namespace fascicle::rig
