// Blend shapes (glTF's morph targets) and their weights over time.
#pragma once

#include <cstdint>
#include <vector>

#include "host/rig/character.h"

namespace fascicle::rig {

// How one shape at weight 1 moves the vertices of a part, in the part's own space, before its skin.
struct BlendShape {
  std::vector<std::uint32_t> vertex;  // those that it moves, ascending
  std::vector<Vector3d> move;         // of each
};

// The weights at `time` (s), held before the first and after the last key: one a shape.
std::vector<double> weights_at(const WeightChannel& channel, double time);

}  // namespace fascicle::rig
