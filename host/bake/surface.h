// The render mesh on the host: for frame 0, which no solver has stepped, and for rest.obj.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "host/model/model.h"

namespace fascicle::bake {

// Stage embed, with its bits: the same products and sums in the same order, values below 2^-40 made zero.
std::vector<float> embed(const model::Model& model, std::span<const float> positions);

// Positions of a frame in metres in the world, rounded once to float: 3 values a vertex.
std::vector<float> world_positions(std::span<const float> positions, double unit,
                                   const std::array<double, 3>& origin);

// Wavefront OBJ of the render mesh at rest (characters: in the bind pose), in its vertex order, metres, Y up.
// A PC2 of the bake can be played on it.
std::string rest_obj(const model::Model& model);

}  // namespace fascicle::bake
