// The render mesh on the host: for frame 0, which no solver has stepped, and for rest.obj.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "host/model/model.h"

namespace fascicle::formats {

// Stage embed, with its bits: the same products and sums in the same order, values below 2^-40 made zero.
std::vector<float> embed(const model::Model& model, std::span<const float> positions);

// Positions of a frame in metres in the world, rounded once to float: 3 values a vertex.
std::vector<float> world_positions(std::span<const float> positions, double unit,
                                   const std::array<double, 3>& origin);

// Throws BakeError without a surface, which formats of the render mesh cannot do without.
void require_surface(const model::Model& model, const std::string& format);

// Least and greatest coordinates of points, x y z x y z. All 0 without points.
std::array<float, 6> bounds(std::span<const float> points);

}  // namespace fascicle::formats
