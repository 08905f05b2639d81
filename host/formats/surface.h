// The render mesh on the CPU: for frame 0, which no solver has stepped, and for rest.obj.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "host/model/model.h"

namespace fascicle::formats {

// Bit-identical to stage embed: the same products and sums in the same order, values below 2^-40 flushed to
// zero.
std::vector<float> embed(const model::Model& model, std::span<const float> positions);

// A frame's world positions in metres, rounded once to float: 3 values per vertex.
std::vector<float> world_positions(std::span<const float> positions, double unit,
                                   const std::array<double, 3>& origin);

// Throws BakeError if there is no surface, which formats of the render mesh need.
void require_surface(const model::Model& model, const std::string& format);

// Minimum and maximum coordinates of the points: x y z x y z. All 0 without points.
std::array<float, 6> bounds(std::span<const float> points);

}  // namespace fascicle::formats
